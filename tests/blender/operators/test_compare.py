"""The comparison: uniform and adaptive copies, side by side, with labels."""

from itertools import pairwise

import bpy
import numpy as np
import pytest
from mathutils import Euler, Vector
from support.meshes import graded_sphere
from support.objects import add_object, key_positions

from adaptive_fairing.blender import operators
from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.jobs.solve import run_solves
from adaptive_fairing.blender.operators.modal_run import ModalRun
from adaptive_fairing.core import FairingSettings, fair
from adaptive_fairing.core.diffusion.smoothing_radius import equivalent_uniform_tau

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    vertices, faces = graded_sphere(2)
    obj = add_object(vertices, faces, name="Ball")
    obj.select_set(True)
    obj.location = (1.0, 2.0, 3.0)
    bpy.context.view_layer.update()
    return obj


def compare(**options):
    return bpy.ops.object.adaptive_fairing_compare(**{"algorithm": "FAIR", **options})


def test_both_copies_are_the_cores_results(obj):
    data = read_mesh(obj.data)
    assert compare(steps=2, tau=0.02) == {"FINISHED"}
    adaptive = FairingSettings(steps=2, tau=0.02)
    tau = float(f"{equivalent_uniform_tau(data.vertices, data.triangles, adaptive):.3g}")
    uniform = FairingSettings(method="uniform", steps=2, tau=tau)
    for name, settings in (("Ball uniform", uniform), ("Ball adaptive", adaptive)):
        expected = fair(data.vertices, data.triangles, settings).positions
        found = key_positions(bpy.data.objects[name], "Fairing 2")
        assert np.array_equal(found, expected.astype(np.float32))


def test_a_uniform_tau_can_be_given(obj):
    compare(steps=1, uniform_tau=0.003)
    assert bpy.data.objects["Ball uniform"].adaptive_fairing.tau == pytest.approx(0.003)


def test_with_the_uniform_scheme_chosen_the_other_copy_is_adaptive(obj):
    compare(steps=1, scheme="UNIFORM", tau=0.02)
    data = read_mesh(obj.data)
    expected = fair(data.vertices, data.triangles, FairingSettings(steps=1, tau=0.02)).positions
    found = key_positions(bpy.data.objects["Ball adaptive"], "Fairing 1")
    assert np.array_equal(found, expected.astype(np.float32))


def test_the_source_is_untouched_and_the_copies_do_not_overlap(obj):
    before = read_positions(obj.data)
    compare(steps=1)
    assert np.array_equal(read_positions(obj.data), before)
    assert obj.data.shape_keys is None
    assert obj.location.x == 1.0
    bpy.context.view_layer.update()
    row = [obj, bpy.data.objects["Ball uniform"], bpy.data.objects["Ball adaptive"]]
    centres = np.array([each.matrix_world.translation for each in row])
    assert (np.diff(centres[:, 0]) > obj.dimensions.x).all()
    assert np.ptp(centres[:, 1:], axis=0) == pytest.approx(0.0, abs=1e-6)


def test_each_has_a_label_below_it(obj):
    compare(steps=1)
    tau = bpy.data.objects["Ball adaptive"].adaptive_fairing.tau
    labels = {each.name: each for each in bpy.data.objects if each.type == "FONT"}
    assert set(labels) == {"Before", "Uniform", "Adaptive"}
    assert labels["Before"].data.body == "Before"
    assert labels["Adaptive"].data.body.startswith(f"Adaptive\nτ = {tau:.3g}\nH ")
    for name, other in (("Before", "Ball"), ("Uniform", "Ball uniform")):
        target = bpy.data.objects[other]
        assert labels[name].location.x == pytest.approx(target.matrix_world.translation.x, abs=0.01)
        assert labels[name].location.z < target.matrix_world.translation.z - 0.9


def test_they_lie_side_by_side_in_the_view_that_the_user_is_in(obj, monkeypatch):
    default = Euler((1.1, 0.0, 0.8)).to_quaternion()  # about that of a new file
    monkeypatch.setattr(operators.compare, "_view_rotation", lambda context: default)
    compare(steps=1)
    bpy.context.view_layer.update()
    row = [obj, bpy.data.objects["Ball uniform"], bpy.data.objects["Ball adaptive"]]
    seen = [on_screen(each, default) for each in row]
    for left, right in pairwise(seen):
        assert right[:, 0].min() > left[:, 0].max()
    for name, shape in zip(("Before", "Uniform", "Adaptive"), seen, strict=True):
        label = bpy.data.objects[name]
        text = on_screen(label, default)
        assert text[:, 1].max() < shape[:, 1].min()
        middles = [(each[:, 0].min() + each[:, 0].max()) / 2 for each in (text, shape)]
        assert middles[0] == pytest.approx(middles[1], abs=0.05)
        assert np.ptp(text[:, 2]) == pytest.approx(0.0, abs=1e-5), "it faces the view"


def on_screen(obj, view):
    """Corners of an object's box to the right, upwards and towards the viewer, (8, 3)."""
    world = [obj.matrix_world @ Vector(corner) for corner in obj.bound_box]
    return np.array([view.inverted() @ corner for corner in world])


def test_an_object_with_an_evolution_gets_a_copy_of_its_undeformed_shape(obj):
    undeformed = read_positions(obj.data)
    bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1, tau=0.1)
    compare(steps=1)
    before = bpy.data.objects["Ball before"]
    assert before.data.shape_keys is None
    assert np.array_equal(read_positions(before.data), undeformed)
    assert "Fairing 1" in obj.data.shape_keys.key_blocks


def test_everything_is_in_one_collection(obj):
    compare(steps=1)
    collection = bpy.data.collections["Fairing Comparison"]
    assert len(collection.objects) == 5
    assert {each.name for each in bpy.context.selected_objects} == {"Ball uniform", "Ball adaptive"}


def test_without_an_active_mesh_it_says_so():
    with pytest.raises(RuntimeError, match="Select a mesh object"):
        compare()


def test_a_mesh_that_was_changed_meanwhile_gets_no_copies(obj, monkeypatch):
    def steps(_operator, solves):
        yield from run_solves(solves)
        obj.data.vertices[0].co.x += 1.0

    monkeypatch.setattr(ModalRun, "_generator", steps)
    with pytest.raises(RuntimeError, match="the mesh was changed during the run"):
        compare(steps=1)
    assert list(bpy.data.objects) == [obj]


def test_a_solver_that_fails_leaves_nothing_behind(obj):
    with pytest.raises(RuntimeError, match="did not converge"):
        compare(steps=1, cg_max_iterations=1, cg_tolerance=1e-12)
    assert list(bpy.data.objects) == [obj]
