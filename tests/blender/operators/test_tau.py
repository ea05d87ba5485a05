"""What τ means on the mesh, and a τ from a wanted radius."""

import bpy
import pytest
from mathutils import Matrix
from support.meshes import graded_sphere, icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import read_mesh
from adaptive_fairing.blender.operators import mesh_scale
from adaptive_fairing.core import FairingSettings
from adaptive_fairing.core.diffusion.smoothing_radius import radius_scale, suggest_tau

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    return add_object(*graded_sphere(2))


@pytest.fixture
def settings():
    return bpy.context.scene.adaptive_fairing


@pytest.mark.parametrize("method", ["uniform", "adaptive_timestep"])
@pytest.mark.parametrize("density", ["edge_length", "area"])
def test_the_suggested_tau_gives_the_wanted_radius(obj, settings, method, density):
    settings.method, settings.density = method, density
    settings.radius, settings.steps = 2.5, 3
    assert bpy.ops.object.adaptive_fairing_suggest_tau() == {"FINISHED"}
    data = read_mesh(obj.data)
    scale = radius_scale(
        data.vertices, data.triangles, FairingSettings(method=method, density=density)
    )
    assert scale.radii(3 * settings.tau)[1] == pytest.approx(2.5, rel=1e-6)


def test_the_mesh_is_measured_anew(obj, settings):
    bpy.ops.object.adaptive_fairing_suggest_tau()
    before = mesh_scale.known_scale(obj, settings)
    obj.data.transform(Matrix.Diagonal((1.0, 1.0, 3.0, 1.0)))
    assert bpy.ops.object.adaptive_fairing_measure() == {"FINISHED"}
    assert mesh_scale.known_scale(obj, settings).radii(0.01) != before.radii(0.01)


def test_it_works_in_edit_mode_on_what_was_edited(obj, settings):
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.adaptive_fairing_suggest_tau()
    assert obj.mode == "EDIT"
    data_size = mesh_scale.known_scale(obj, settings)
    assert data_size is not None


def test_a_mesh_without_faces_is_refused():
    add_object([[0, 0, 0], [1, 0, 0]], [])
    with pytest.raises(RuntimeError, match="the mesh has no triangles"):
        bpy.ops.object.adaptive_fairing_suggest_tau()


def test_without_a_mesh_it_says_so():
    with pytest.raises(RuntimeError, match="Make a mesh object active"):
        bpy.ops.object.adaptive_fairing_suggest_tau()


class TestMemory:
    def test_a_mesh_is_unknown_until_it_is_measured(self, obj, settings):
        assert mesh_scale.known_scale(obj, settings) is None
        scale = mesh_scale.measure(obj, settings)
        assert mesh_scale.known_scale(obj, settings) is scale

    def test_another_density_is_another_scale(self, obj, settings):
        mesh_scale.measure(obj, settings)
        settings.density = "area"
        assert mesh_scale.known_scale(obj, settings) is None

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


def test_tau_follows_the_radius_of_a_paper_method(obj, settings):
    settings.method = "adaptive_timestep"
    settings.radius = 0.8
    first = settings.tau
    scale = mesh_scale.known_scale(obj, settings)
    assert first == pytest.approx(suggest_tau(scale, 0.8, settings.steps), rel=1e-6)
    settings.radius = 1.6
    assert settings.tau == pytest.approx(4 * first, rel=1e-5)
