"""Presets: those that come along, and the user's own."""

from pathlib import Path

import bpy
import pytest

from adaptive_fairing.blender.properties import SOLVER_NAMES, solver_settings
from adaptive_fairing.blender.ui import presets
from adaptive_fairing.core import DenoiseSettings, FairingSettings

pytestmark = pytest.mark.usefixtures("addon")

SHIPPED = sorted(Path(presets._SHIPPED).glob("presets/adaptive_fairing/*.py"))


@pytest.fixture(autouse=True)
def _same_title():
    """Blender renames the panel to the preset that was chosen last."""
    panel = bpy.types.VIEW3D_PT_adaptive_fairing_presets
    title = panel.bl_label
    yield
    panel.bl_label = title


def execute(path):
    return bpy.ops.script.execute_preset(
        filepath=str(path), menu_idname="VIEW3D_PT_adaptive_fairing_presets"
    )


def test_blender_finds_the_folder():
    assert str(SHIPPED[0].parent) in bpy.utils.preset_paths("adaptive_fairing")
    assert len(SHIPPED) == 7


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_preset_that_comes_along_sets_scheme_and_density_whatever_was_set(path):
    found = []
    for scheme, density, passes, steps in (
        ("UNIFORM", "AREA", 9, 1),
        ("TENSOR", "EDGE", 0, 7),
    ):
        settings = bpy.context.scene.adaptive_fairing
        settings.scheme, settings.density, settings.density_passes = scheme, density, passes
        settings.steps, settings.radius, settings.tau = steps, 0.7, 0.3
        settings.use_tau = scheme == "TENSOR"
        assert execute(path) == {"FINISHED"}
        found.append(solver_settings(settings))
    assert found[0] == found[1]


def test_one_leads_back_to_denoise():
    settings = bpy.context.scene.adaptive_fairing
    settings.algorithm, settings.strength, settings.features = "FAIR", 1.7, "sharp"
    (path,) = [path for path in SHIPPED if path.stem == "Denoise"]
    execute(path)
    assert solver_settings(settings) == DenoiseSettings()


def test_the_papers_head_has_the_papers_tau():
    (path,) = [path for path in SHIPPED if path.stem == "Fairing_Paper_Head"]
    execute(path)
    assert solver_settings(bpy.context.scene.adaptive_fairing) == FairingSettings(tau=0.016)


def test_a_preset_of_ones_own_brings_every_setting_back(tmp_path, monkeypatch):
    monkeypatch.setattr(
        bpy.utils, "user_resource", lambda *_, path="", **__: _made(tmp_path / path)
    )
    settings = bpy.context.scene.adaptive_fairing
    settings.algorithm, settings.scheme, settings.steps = "FAIR", "TENSOR", 9
    settings.use_tau, settings.tau = True, 0.0107
    settings.boundary, settings.stop_rate = "free", 0.25
    wanted = solver_settings(settings)
    assert bpy.ops.object.adaptive_fairing_preset_add(name="Mine") == {"FINISHED"}
    for name in SOLVER_NAMES:
        settings.property_unset(name)
    assert solver_settings(settings) == DenoiseSettings()
    (path,) = tmp_path.rglob("Mine.py")
    execute(path)
    assert solver_settings(settings) == wanted


def _made(path):
    path.mkdir(parents=True, exist_ok=True)
    return str(path)
