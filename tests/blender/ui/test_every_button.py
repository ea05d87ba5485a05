"""Every button of the panels is pressed by some test."""

from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest
from support.layouts import PANELS, draw
from support.meshes import noisy_ball
from support.objects import add_object

from adaptive_fairing.blender.jobs.solve import Solve
from adaptive_fairing.blender.operators import modal_run
from adaptive_fairing.core import DenoiseSettings

pytestmark = pytest.mark.usefixtures("addon")

TESTS = Path(__file__).resolve().parents[2]


def shown_buttons():
    drawn = [draw(panel) for panel in PANELS]
    return {button["name"] for each in drawn if each is not None for button in each.operators}


@pytest.fixture
def buttons():
    """Operators of all buttons, before, during and after runs of both kinds."""
    noisy = add_object(*noisy_ball(3, 0.02))
    noisy.select_set(True)
    found = shown_buttons()
    bpy.ops.object.adaptive_fairing()
    bpy.ops.object.adaptive_fairing_view(field="REMOVED")
    found |= shown_buttons()
    bpy.ops.object.adaptive_fairing_material()
    found |= shown_buttons()
    bpy.context.scene.adaptive_fairing.algorithm = "FAIR"
    bpy.ops.object.adaptive_fairing(algorithm="FAIR", scheme="UNIFORM", steps=2, tau=0.001)
    bpy.ops.object.adaptive_fairing_animate()
    noisy.adaptive_fairing.notes = "found"
    found |= shown_buttons()
    solve = Solve(*noisy_ball(1, 0.02), DenoiseSettings())
    worker = SimpleNamespace(is_stopping=False, stop=lambda: None, join=lambda timeout: None)
    modal_run._progress[:] = [modal_run.Progress([solve], worker)]
    found |= shown_buttons()
    modal_run.forget_run()
    return found


def test_every_button_is_pressed_by_a_test(buttons):
    own = Path(__file__).name
    text = "\n".join(path.read_text("utf-8") for path in TESTS.rglob("*.py") if path.name != own)
    assert len(buttons) > 15
    assert {name for name in buttons if f"bpy.ops.{name}(" not in text} == set()
