"""The ring of a Noise Size that was given: where it is, how large, and when there is one."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Euler, Matrix, Vector
from support.meshes import noisy_ball
from support.objects import add_object

from adaptive_fairing.blender.operators import mesh_scale
from adaptive_fairing.blender.operators.viewport import views
from adaptive_fairing.blender.ui import noise_ring
from adaptive_fairing.blender.ui.noise_ring import bump_radius, ring, ring_in_pixels, surface_point
from adaptive_fairing.blender.ui.view_lines import sight

pytestmark = pytest.mark.usefixtures("addon")

SIGHT = Vector((0.3, 0.9, -0.2))


@pytest.fixture
def ball():
    """An active ball of radius 1 that is moved, turned and scaled by 2, and measured."""
    obj = add_object(*noisy_ball(3, 0.0))
    obj.location, obj.scale = (5.0, -3.0, 2.0), (2.0, 2.0, 2.0)
    obj.rotation_euler = Euler((0.3, 0.5, 0.7))
    bpy.context.view_layer.update()
    settings = bpy.context.scene.adaptive_fairing
    settings.width = 3.0
    mesh_scale.measure(obj, settings)
    return obj


@pytest.fixture
def view(ball):
    """What a 3D view with our tab draws with; there is no window to draw one in."""
    space = next(space for _, space in views() if space.id_data.name == "Layout")
    space.show_region_ui = True
    return SimpleNamespace(
        scene=bpy.context.scene,
        active_object=ball,
        space_data=space,
        region_data=space.region_3d,
        area=SimpleNamespace(regions=[SimpleNamespace(type="UI", active_panel_category="Fairing")]),
    )


def test_the_ring_is_a_closed_circle_across_the_line_of_sight():
    centre = Vector((5.0, -3.0, 2.0))
    points = ring(centre, SIGHT, 0.25)
    assert points[0] == points[-1]
    spokes = np.array([point - centre for point in points])
    assert np.linalg.norm(spokes, axis=1) == pytest.approx(0.25, abs=1e-5)
    assert spokes @ np.array(SIGHT) == pytest.approx(0.0, abs=1e-5)
    steps = np.linalg.norm(np.diff(spokes, axis=0), axis=1)
    assert steps == pytest.approx(2 * np.pi * 0.25 / (len(points) - 1), rel=0.01)


def test_it_lies_where_the_middle_of_the_view_meets_the_surface(ball):
    middle = ball.matrix_world.translation
    eye = middle - 10 * SIGHT + Vector((0.5, 0.0, 0.5))
    place = surface_point(ball, eye, SIGHT)
    assert (place - eye).cross(SIGHT).length == pytest.approx(0.0, abs=1e-4)
    assert (place - middle).length == pytest.approx(2.0, rel=0.02)
    assert (place - middle).dot(SIGHT) < 0, "before the middle"


def test_beside_the_object_it_lies_towards_the_middle_of_that(ball):
    middle = ball.matrix_world.translation
    eye = middle - 10 * SIGHT
    place = surface_point(ball, eye, Vector((0.0, 0.0, 1.0)))
    assert (place - eye).normalized().dot(SIGHT.normalized()) == pytest.approx(1.0, abs=1e-3)
    assert (place - middle).length == pytest.approx(2.0, rel=0.02)


def test_without_a_surface_to_hit_it_lies_in_the_middle(ball):
    middle = ball.matrix_world.translation
    ball.scale = (0.0, 0.0, 0.0)
    bpy.context.view_layer.update()
    assert surface_point(ball, middle - SIGHT, SIGHT) == middle
    ball.hide_viewport = True
    bpy.context.view_layer.update()
    assert surface_point(ball, middle - SIGHT, SIGHT) == middle


def look(view, place, turn, is_perspective):
    """Look from a place along the negative z axis of a turn, as no view does without a window."""
    near, far, wide = 0.1, 100.0, 0.5
    lens = Matrix.Diagonal((1 / 8, 1 / 6, -2 / (far - near), 1.0))
    if is_perspective:
        depth = (far + near) / (near - far), 2 * far * near / (near - far)
        lens = Matrix(((1 / wide, 0, 0, 0), (0, 4 / 3 / wide, 0, 0), (0, 0, *depth), (0, 0, -1, 0)))
    view_matrix = (Matrix.Translation(place) @ turn.to_matrix().to_4x4()).inverted()
    view.region = SimpleNamespace(width=800, height=600)
    view.region_data = SimpleNamespace(
        view_matrix=view_matrix,
        view_rotation=turn.to_quaternion(),
        perspective_matrix=lens @ view_matrix,
        is_perspective=is_perspective,
        view_perspective="PERSP" if is_perspective else "ORTHO",
    )


@pytest.mark.parametrize("is_perspective", [True, False])
def test_the_view_shows_it_in_its_middle_as_large_as_it_is_there(ball, view, is_perspective):
    turn, middle = Euler((1.0, 0.2, 0.5)), ball.matrix_world.translation
    towards = turn.to_matrix().col[2]
    look(view, middle + 20 * towards, turn, is_perspective)
    points = np.array(ring_in_pixels(view, 0.25))
    centre = np.array((400.0, 300.0))
    assert points[:-1].mean(axis=0) == pytest.approx(centre, abs=0.5)
    front = middle + 2 * towards
    ends = front, front + 0.25 * turn.to_matrix().col[0]
    start, end = (location_3d_to_region_2d(view.region, view.region_data, each) for each in ends)
    radii = np.linalg.norm(points - centre, axis=1)
    assert radii == pytest.approx((end - start).length, rel=0.02)


def test_nothing_of_it_is_drawn_if_a_part_is_behind_the_viewer(ball, view):
    look(view, ball.matrix_world.translation + Vector((9.0, 0.0, 0.0)), Euler(), True)
    assert ring_in_pixels(view, 0.25) == []


def test_its_radius_is_the_length_in_the_panel(ball, view):
    scale = mesh_scale.known_scale(ball, view.scene.adaptive_fairing)
    assert bump_radius(view) == pytest.approx(3.0 * scale.edge_typical * 2.0, rel=1e-5)
    ball.scale = (1.0, 2.0, 6.0)
    bpy.context.view_layer.update()
    mean = ((1.0 + 4.0 + 36.0) / 3) ** 0.5  # Blender's
    assert bump_radius(view) == pytest.approx(3.0 * scale.edge_typical * mean, rel=1e-5)
    ball.scale = (0.0, 0.0, 0.0)
    bpy.context.view_layer.update()
    assert bump_radius(view) is None


def _automatic(view):
    view.scene.adaptive_fairing.width = 0.0


def _the_paper(view):
    view.scene.adaptive_fairing.algorithm = "FAIR"


def _another_tab(view):
    view.area.regions[0].active_panel_category = "View"


def _no_sidebar(view):
    view.space_data.show_region_ui = False


def _no_overlays(view):
    view.space_data.overlay.show_overlays = False


def _nothing_active(view):
    view.active_object = None


def _a_light(view):
    view.active_object = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT"))


def _hidden(view):
    view.active_object.hide_set(True)


def _edited(view):
    bpy.ops.object.mode_set(mode="EDIT")


def _not_measured(view):
    view.active_object.data.transform(Matrix.Scale(2.0, 4))


def _no_surface(view):
    view.active_object = add_object([[0, 0, 0], [1, 0, 0]], [])
    mesh_scale.measure(view.active_object, view.scene.adaptive_fairing)


def _no_view(view):
    view.region_data = None


@pytest.mark.parametrize(
    "change",
    [
        _automatic,
        _the_paper,
        _another_tab,
        _no_sidebar,
        _no_overlays,
        _nothing_active,
        _a_light,
        _hidden,
        _edited,
        _not_measured,
        _no_surface,
        _no_view,
    ],
)
def test_there_is_none(view, change):
    assert bump_radius(view) is not None
    change(view)
    try:
        assert bump_radius(view) is None
    finally:
        if view.active_object and view.active_object.mode == "EDIT":
            bpy.ops.object.mode_set(mode="OBJECT")


def test_an_automatic_size_costs_a_look_at_the_settings_alone():
    settings = SimpleNamespace(algorithm="DENOISE", width=0.0)
    assert bump_radius(SimpleNamespace(scene=SimpleNamespace(adaptive_fairing=settings))) is None


def test_it_faces_the_eye_in_perspective_and_the_view_without():
    turn = Euler((0.3, 0.5, 0.7)).to_matrix().to_4x4()
    matrix = Matrix.Translation((1.0, 2.0, 3.0)) @ turn
    seen = SimpleNamespace(
        view_matrix=matrix.inverted(), view_rotation=turn.to_quaternion(), is_perspective=True
    )
    point = Vector((4.0, -1.0, 0.0))
    context = SimpleNamespace(region_data=seen)
    assert (sight(context, point) - (point - matrix.translation)).length < 1e-5
    seen.is_perspective = False
    assert (sight(context, point) + turn.to_3x3().col[2]).length < 1e-5


def test_it_is_drawn_by_one_handler_until_the_add_on_is_disabled(monkeypatch):
    drawn = []
    space = SimpleNamespace(
        draw_handler_add=lambda draw, arguments, region, moment: drawn.append(region) or region,
        draw_handler_remove=lambda handler, region: drawn.remove(region),
    )
    monkeypatch.setattr(noise_ring, "_handlers", [])
    monkeypatch.setattr(bpy, "types", SimpleNamespace(SpaceView3D=space))
    for _ in range(2):
        noise_ring.register()
        assert drawn == ["WINDOW"]
        noise_ring.unregister()
        assert drawn == []
