"""Scale of τ and of the radius on the mesh at hand, as the panel looks it up."""

from dataclasses import astuple

import bpy
import pytest
from mathutils import Matrix
from support.meshes import graded_sphere, icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import read_mesh
from adaptive_fairing.blender.jobs.kept_preparation import preparations
from adaptive_fairing.blender.operators import mesh_scale
from adaptive_fairing.core import FairingSettings
from adaptive_fairing.core.diffusion import smoothing_radius
from adaptive_fairing.core.diffusion.smoothing_radius import radius_scale

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    obj = add_object(*graded_sphere(2))
    obj.select_set(True)
    return obj


@pytest.fixture
def settings():
    return bpy.context.scene.adaptive_fairing


def known_now(obj, settings):
    assert bpy.ops.object.adaptive_fairing_measure() == {"FINISHED"}
    return mesh_scale.known_scale(obj, settings)


def test_it_is_the_cores(obj, settings):
    data = read_mesh(obj.data)
    expected = radius_scale(data.vertices, data.triangles, FairingSettings())
    assert known_now(obj, settings) == expected


def test_in_edit_mode_nothing_is_known(obj, settings):
    mesh_scale.measure(obj, settings)
    bpy.ops.object.mode_set(mode="EDIT")
    assert mesh_scale.known_scale(obj, settings) is None
    with pytest.raises(RuntimeError, match="Leave Edit Mode to measure the mesh"):
        bpy.ops.object.adaptive_fairing_measure()


def test_a_mesh_without_faces_is_refused():
    add_object([[0, 0, 0], [1, 0, 0]], [])
    with pytest.raises(RuntimeError, match="the mesh has no triangles"):
        bpy.ops.object.adaptive_fairing_measure()


def test_without_a_mesh_it_says_so():
    with pytest.raises(RuntimeError, match="Make a mesh object active"):
        bpy.ops.object.adaptive_fairing_measure()


@pytest.mark.parametrize("scheme", ["UNIFORM", "TIMESTEP", "TENSOR"])
@pytest.mark.parametrize("density", ["EDGE", "AREA"])
@pytest.mark.parametrize("normalize", ["BOX", "NONE"])
def test_the_radius_that_is_set_is_what_runs(obj, settings, scheme, density, normalize):
    """For every change of mesh, steps and density: nothing is remembered between runs."""
    settings.algorithm, settings.scheme, settings.density = "FAIR", scheme, density
    settings.normalize = normalize
    for radius, steps in ((0.8, 2), (0.3, 3)):
        obj.data.transform(Matrix.Diagonal((1.0, 1.3, 2.0, 1.0)))
        scale = known_now(obj, settings)
        words = {"scheme": scheme, "density": density, "normalize": normalize}
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", radius=radius, steps=steps, **words)
        ran = scale.radii(steps * obj.adaptive_fairing.tau)[1]
        assert ran == pytest.approx(radius, rel=1e-5)
        bpy.ops.object.adaptive_fairing_discard()


class TestMemory:
    def test_a_mesh_is_unknown_until_it_is_measured(self, obj, settings):
        assert mesh_scale.known_scale(obj, settings) is None
        scale = mesh_scale.measure(obj, settings)
        assert mesh_scale.known_scale(obj, settings) is scale

    def test_another_density_is_another_scale(self, obj, settings):
        mesh_scale.measure(obj, settings)
        settings.density = "AREA"
        assert mesh_scale.known_scale(obj, settings) is None

    def test_another_shape_is_another_scale(self, obj, settings):
        mesh_scale.measure(obj, settings)
        obj.data.vertices[0].co.x += 0.1
        assert mesh_scale.known_scale(obj, settings) is None

    def test_what_is_shown_counts_or_the_original(self, obj, settings):
        before = mesh_scale.measure(obj, settings)
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", radius=2.0)
        assert mesh_scale.known_scale(obj, settings) is None
        assert mesh_scale.measure(obj, settings) != before
        settings.from_original = True
        assert mesh_scale.measure(obj, settings) == before

    def test_another_strength_of_a_modifier_is_another_scale(self, noisy, settings):
        bpy.ops.object.adaptive_fairing(result="MODIFIER")
        mesh_scale.measure(noisy, settings)
        noisy.adaptive_fairing.strength = 0.3
        assert mesh_scale.known_scale(noisy, settings) is None

    def test_a_run_leaves_its_set_up(self, obj, settings, monkeypatch):
        # No other test asks for this radius: what one has solved would be taken from there.
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", radius=1.9)
        with monkeypatch.context() as known:
            known.setattr(smoothing_radius, "solvable_surface", None)
            found = mesh_scale.measure(obj, settings)
        preparations.clear()
        assert astuple(found) == pytest.approx(astuple(mesh_scale.measure(obj, settings)))

    def test_tau_and_steps_do_not_matter(self, obj, settings):
        scale = mesh_scale.measure(obj, settings)
        settings.tau, settings.steps = 0.5, 9
        assert mesh_scale.known_scale(obj, settings) is scale

    def test_it_is_bounded(self, settings):
        obj = add_object(*icosphere(0))
        for passes in range(mesh_scale.REMEMBERED + 5):
            settings.density_passes = passes
            mesh_scale.measure(obj, settings)
        assert len(mesh_scale._known) == mesh_scale.REMEMBERED

    def test_another_file_starts_empty(self, obj, settings):
        mesh_scale.measure(obj, settings)
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        assert not mesh_scale._known

    def test_what_the_panel_asks_for_is_measured_after_drawing(self, obj, settings):
        assert mesh_scale.measure_soon(obj, settings)
        assert bpy.app.timers.is_registered(mesh_scale._measure_wanted)
        bpy.app.timers.unregister(mesh_scale._measure_wanted)
        mesh_scale._measure_wanted()
        assert mesh_scale.known_scale(obj, settings) is not None

    def test_a_large_mesh_is_not_measured_unasked(self, obj, settings, monkeypatch):
        monkeypatch.setattr(mesh_scale, "LARGEST_UNASKED", 10)
        assert not mesh_scale.measure_soon(obj, settings)
