"""Check Mesh: what the panel says of a mesh before a run, and that nothing is changed."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from support import bad_meshes, meshes
from support.layouts import draw
from support.objects import add_object
from support.results import coordinates

from adaptive_fairing.blender.operators.check import check_of
from adaptive_fairing.blender.ui.check_panel import VIEW3D_PT_adaptive_fairing_check
from adaptive_fairing.core import DenoiseSettings
from adaptive_fairing.core.denoising.examination import examine

pytestmark = pytest.mark.usefixtures("addon")

SELECT = "object.adaptive_fairing_select_problems"


def added(mesh):
    obj = add_object(*mesh)
    obj.select_set(True)
    return obj


def check():
    return bpy.ops.object.adaptive_fairing_check()


def drawn():
    return draw(VIEW3D_PT_adaptive_fairing_check)


def test_it_says_what_the_core_finds_and_changes_nothing(capfd):
    vertices, faces = meshes.noisy_ball(3, 0.02)
    obj = added((vertices, faces))
    before, attributes = coordinates(obj), obj.data.attributes.keys()
    assert drawn().texts == []
    assert check() == {"FINISHED"}
    expected = examine(before.astype(float), faces)
    assert check_of(obj).noise_level == pytest.approx(expected.noise_level, rel=1e-9)
    assert check_of(obj).counts == expected.counts
    shown = drawn().texts
    assert shown[0].startswith(f"Noise: {expected.noise_level:.2g} edges  ·  ")
    assert {"Parts: 1", "Holes and outer boundaries: 0"} <= set(shown)
    assert f"Thing: noise of {expected.noise_level:.2g} edges" in capfd.readouterr().out
    assert np.array_equal(coordinates(obj), before)
    assert obj.data.attributes.keys() == attributes
    assert not obj.adaptive_fairing.result


def test_it_is_for_the_noise_size_of_the_panel():
    """Bumps of a few edges are noise because the user says so."""
    vertices, faces = meshes.icosphere(3)
    vertices = vertices * (1 + 0.02 * np.sin(9 * vertices).prod(axis=1))[:, None]
    obj = added((vertices, faces))
    bpy.context.scene.adaptive_fairing.width = 2.0
    check()
    expected = examine(coordinates(obj).astype(float), faces, DenoiseSettings(width=2.0))
    assert check_of(obj).noise_level == pytest.approx(expected.noise_level, rel=1e-9)
    assert check_of(obj).noise_level > 0
    assert examine(vertices, faces).noise_level == 0
    bpy.context.scene.adaptive_fairing.width = 0.0
    assert drawn().texts == []


def test_the_noise_is_a_length_of_the_world():
    obj = added(meshes.noisy_ball(3, 0.02))
    check()
    of_one = drawn().texts[0]
    obj.scale = (10.0, 10.0, 10.0)
    bpy.context.view_layer.update()
    of_ten = drawn().texts[0]
    assert of_one.endswith(" cm")
    centimetres = [float(text.rsplit("·")[-1].replace("cm", "")) for text in (of_one, of_ten)]
    assert centimetres[1] == pytest.approx(10 * centimetres[0], rel=0.01)


def test_a_clean_mesh_looks_clean_and_the_reason_is_told():
    added(meshes.noisy_ball(3, 0.0))
    check()
    shown = drawn()
    assert shown.texts[0] == "Looks clean"
    assert "no noise found" in " ".join(shown.texts)
    assert "Parts: 1" in shown.marked


def test_what_is_wrong_is_counted_and_can_be_selected():
    obj = added(bad_meshes.everything_wrong())
    check()
    found, shown = check_of(obj), drawn()
    assert f"Parts: {found.counts.n_parts}" in shown.texts
    assert f"Vertices that are held: {len(found.problems.held)}" in shown.texts
    assert len(found.problems.held) > 0
    assert f"Vertices that are held: {len(found.problems.held)}" not in shown.marked
    assert SELECT in {button["name"] for button in shown.operators}
    added(meshes.noisy_ball(2, 0.02))
    check()
    assert SELECT not in {button["name"] for button in drawn().operators}


def test_it_is_shown_as_long_as_the_mesh_has_that_shape():
    obj = added(meshes.noisy_ball(2, 0.02))
    check()
    obj.data.transform(Matrix.Scale(2.0, 4))
    assert check_of(obj) is None
    obj.data.transform(Matrix.Scale(0.5, 4))
    assert check_of(obj) is not None
    other = added(meshes.noisy_ball(2, 0.01))
    assert check_of(other) is None


@pytest.mark.parametrize("mode", ["EDIT", "SCULPT", "WEIGHT_PAINT"])
def test_it_works_from_every_mode_and_comes_back(mode):
    obj = added(meshes.noisy_ball(2, 0.02))
    bpy.ops.object.mode_set(mode=mode)
    check()
    assert obj.mode == mode
    assert check_of(obj) is not None


def test_it_is_forgotten_with_the_file():
    obj = added(meshes.noisy_ball(2, 0.02))
    check()
    uid = obj.session_uid
    bpy.ops.wm.read_homefile(use_empty=True)
    from adaptive_fairing.blender.operators import check as module

    assert uid not in module.checks


def test_a_mesh_without_faces_is_refused_in_a_line():
    added((np.eye(3), []))
    with pytest.raises(RuntimeError, match=r"Thing: .*triangle"):
        check()
    assert drawn().texts == []
