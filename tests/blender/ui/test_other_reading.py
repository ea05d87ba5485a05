"""The panel says what the roughness of a mesh was taken for, and offers the other reading."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from support import meshes
from support.layouts import draw
from support.objects import add_object
from support.results import coordinates

from adaptive_fairing.blender.operators import readings
from adaptive_fairing.blender.ui.settings_panel import VIEW3D_PT_adaptive_fairing
from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

pytestmark = pytest.mark.usefixtures("addon")

RUN = "object.adaptive_fairing"


def selected(vertices, faces):
    obj = add_object(vertices, faces)
    obj.select_set(True)
    return obj


def model():
    """A clean low-poly model of Blender's, with creases that count as noise if all does."""
    bpy.ops.mesh.primitive_monkey_add()
    return bpy.context.active_object


def scanned():
    """A torus with smooth noise, as a scanner makes it."""
    vertices, faces = meshes.torus(104, 52)
    frame = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    heights = frame.spread(np.random.default_rng(0).normal(size=len(vertices)), 4)
    return selected(vertices + frame.raised(0.2 * heights / heights.std()), faces)


def offered():
    """Buttons that run with another reading, and the texts beside them."""
    drawn = draw(VIEW3D_PT_adaptive_fairing)
    return drawn, [each for each in drawn.operators if each["name"] == RUN][1:]


def press(button):
    settings = {k: v for k, v in button.items() if k not in ("name", "text", "depress")}
    return bpy.ops.object.adaptive_fairing(**settings)


def test_nothing_is_offered_before_a_run_and_where_noise_was_found():
    noisy = selected(*meshes.noisy_ball(3, 0.02))
    assert offered()[1] == []
    bpy.ops.object.adaptive_fairing()
    assert noisy.adaptive_fairing.result
    assert offered()[1] == []


def test_a_clean_model_is_named_and_can_be_denoised_anyway():
    obj = model()
    before = coordinates(obj)
    assert bpy.ops.object.adaptive_fairing() == {"CANCELLED"}
    drawn, (button,) = offered()
    assert button["text"] == "Denoise Anyway"
    assert any("looks like a clean" in text or "no noise" in text for text in drawn.texts)
    assert press(button) == {"FINISHED"}
    assert not np.array_equal(coordinates(obj), before)
    assert offered()[1] == []


def test_smooth_noise_is_removed_and_a_click_takes_it_for_detail():
    obj = scanned()
    before = coordinates(obj)
    assert bpy.ops.object.adaptive_fairing() == {"FINISHED"}
    assert not np.array_equal(coordinates(obj), before)
    _, (button,) = offered()
    assert button["text"] == "Keep Fine Detail"
    assert press(button) == {"FINISHED"}
    np.testing.assert_array_equal(coordinates(obj), before)
    assert not obj.adaptive_fairing.result
    _, (button,) = offered()
    assert button["text"] == "Denoise Anyway"


def test_changes_by_hand_are_not_lost_when_the_original_is_asked_for():
    obj = scanned()
    bpy.ops.object.adaptive_fairing()
    _, (button,) = offered()
    obj.data.transform(Matrix.Translation((1, 0, 0)))
    changed = coordinates(obj)
    assert offered()[1] == []
    press(button)
    np.testing.assert_array_equal(coordinates(obj), changed)


def test_it_is_forgotten_with_the_file():
    obj = model()
    bpy.ops.object.adaptive_fairing()
    assert readings.reading_of(obj) is not None
    bpy.ops.wm.read_homefile(use_empty=True)
    assert readings.readings == {}


def test_another_algorithm_and_another_object_show_nothing():
    model()
    bpy.ops.object.adaptive_fairing()
    bpy.context.scene.adaptive_fairing.algorithm = "FAIR"
    assert offered()[1] == []
    bpy.context.scene.adaptive_fairing.algorithm = "DENOISE"
    assert len(offered()[1]) == 1
    add_object(*meshes.noisy_ball(2, 0.02))
    assert offered()[1] == []


@pytest.mark.parametrize("algorithm", ["DENOISE", "FAIR"])
def test_a_refusal_stays_to_be_read_until_the_next_run_begins(algorithm):
    selected(*meshes.noisy_ball(3, 0.02))
    bpy.context.scene.adaptive_fairing.algorithm = algorithm
    with pytest.raises(RuntimeError, match="no vertex group 'skin'"):
        bpy.ops.object.adaptive_fairing(algorithm=algorithm, vertex_group="skin")
    assert "there is no vertex group 'skin'" in " ".join(offered()[0].texts)
    bpy.ops.object.adaptive_fairing(algorithm=algorithm)
    assert "vertex group" not in " ".join(offered()[0].texts)


def test_a_later_refusal_takes_the_place_of_an_earlier_note():
    model()
    bpy.ops.object.adaptive_fairing()
    with pytest.raises(RuntimeError, match="skin"):
        bpy.ops.object.adaptive_fairing(vertex_group="skin")
    drawn, buttons = offered()
    assert "there is no vertex group" in " ".join(drawn.texts)
    assert not any("noise" in text for text in drawn.texts)
    assert buttons == []


def test_a_run_of_the_other_algorithm_ends_an_earlier_note():
    model()
    bpy.ops.object.adaptive_fairing()
    bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
    bpy.ops.object.adaptive_fairing_discard()
    assert offered()[1] == []


def test_what_was_said_of_another_shape_is_not_shown():
    obj = model()
    bpy.ops.object.adaptive_fairing()
    before = coordinates(obj)
    obj.data.transform(Matrix.Diagonal((1, 1, 2, 1)))
    drawn, buttons = offered()
    assert buttons == []
    assert not any("noise" in text for text in drawn.texts)
    obj.data.transform(Matrix.Diagonal((1, 1, 0.5, 1)))
    assert np.array_equal(coordinates(obj), before)
    assert len(offered()[1]) == 1


def test_what_was_said_of_a_result_ends_with_it():
    scanned()
    bpy.ops.object.adaptive_fairing()
    bpy.context.active_object.adaptive_fairing.strength = 0.3
    assert len(offered()[1]) == 1
    bpy.ops.object.adaptive_fairing_discard()
    assert offered()[1] == []


def test_why_nothing_was_done_is_said_where_there_is_no_other_reading():
    bpy.ops.mesh.primitive_cube_add()
    assert bpy.ops.object.adaptive_fairing() == {"CANCELLED"}
    drawn, buttons = offered()
    assert buttons == []
    assert "too few to tell noise from shape" in " ".join(drawn.texts)
