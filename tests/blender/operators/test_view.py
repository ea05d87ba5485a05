"""Colours: density, displacement, mean curvature, and the switch of the viewport."""

import bpy
import numpy as np
import pytest
from support.bad_meshes import three_sheets
from support.meshes import ellipsoid, flat_hexagon, icosphere, noisy_ball
from support.objects import add_object, numbers, shown_positions

from adaptive_fairing.blender.data.color_map import CURVATURE_FIELDS, color_range
from adaptive_fairing.blender.data.coloring import FIELD_ATTRIBUTES
from adaptive_fairing.blender.data.fields import measure_field
from adaptive_fairing.blender.data.shape_keys import write_absolute_keys
from adaptive_fairing.core import (
    FairingSettings,
    InputError,
    LimitSurface,
    TriangleTopology,
    fair,
)
from adaptive_fairing.core.diffusion.settings import DENSITIES

pytestmark = pytest.mark.usefixtures("addon")


def show(field):
    return bpy.ops.object.adaptive_fairing_view(field=field)


def add_selected(vertices, faces):
    obj = add_object(vertices, faces)
    obj.select_set(True)
    return obj


class TestCurvature:
    """Of the limit surface: exact values are tested with the core, here what becomes of them."""

    @pytest.mark.parametrize(("field", "power"), [("CURVATURE", 1), ("GAUSSIAN", 2)])
    def test_a_sphere_has_powers_of_one_over_r(self, field, power):
        errors = []
        for levels in (2, 3, 4):
            vertices, faces = icosphere(levels)
            obj = add_selected(2.0 * vertices, faces)
            show(field)
            found = numbers(obj.data, FIELD_ATTRIBUTES[field])
            errors.append(np.abs(np.median(found) - 0.5**power))
        assert errors[2] < errors[1] / 3 < errors[0] / 9

    def test_it_is_that_of_the_cores_limit_surface(self):
        vertices, faces = ellipsoid(2, (1.0, 2.0, 3.0))
        vertices = np.float32(vertices)
        surface = LimitSurface(TriangleTopology(faces, len(vertices)), vertices)
        obj = add_object(vertices, faces)
        for field, exact in (
            ("CURVATURE", surface.mean_curvature),
            ("GAUSSIAN", surface.gaussian_curvature),
        ):
            assert np.array_equal(measure_field(obj, field, FairingSettings()).values, exact)

    def test_a_sphere_turned_inside_out_has_the_opposite_mean_curvature(self):
        vertices, faces = icosphere(2)
        out, inward = (
            {
                field: measure_field(obj, field, FairingSettings()).values
                for field in CURVATURE_FIELDS
            }
            for obj in (add_object(vertices, faces), add_object(vertices, faces[:, ::-1]))
        )
        assert inward["CURVATURE"] == pytest.approx(-out["CURVATURE"], rel=1e-9)
        assert inward["GAUSSIAN"] == pytest.approx(out["GAUSSIAN"], rel=1e-9)
        assert (out["GAUSSIAN"] > 0).all()

    @pytest.mark.parametrize("field", ["CURVATURE", "GAUSSIAN"])
    def test_a_plane_has_none_up_to_its_boundary(self, field):
        vertices, faces = flat_hexagon(4)
        vertices = np.concatenate([vertices, [[0.0, 0.0, 9.0]]])
        values = measure_field(add_object(vertices, faces), field, FairingSettings()).values
        assert values[:-1] == pytest.approx(0.0, abs=1e-9)
        assert np.isnan(values[-1])  # a loose vertex

    def test_a_cut_in_the_surface_is_no_obstacle(self):
        obj = add_object(*three_sheets())
        assert np.isfinite(measure_field(obj, "GAUSSIAN", FairingSettings()).values).all()

    def test_marked_edges_are_creases(self):
        vertices, faces = icosphere(2)
        smooth, marked = add_object(vertices, faces), add_object(vertices, faces)
        equator = np.abs(vertices[:, 2]) < 1e-6
        for edge in marked.data.edges:
            edge.use_edge_sharp = bool(equator[list(edge.vertices)].all())
        values = [
            measure_field(obj, "CURVATURE", FairingSettings()).values for obj in (smooth, marked)
        ]
        differs = values[0] != values[1]
        assert differs.any() and not differs[np.abs(vertices[:, 2]) > 0.5].any()


class TestRemoved:
    """Blown up or shrunk spheres, whose vertices have all moved along their normals."""

    @pytest.fixture(params=[0.9, 1.1])
    def factor(self, request):
        return request.param

    @pytest.fixture
    def obj(self, factor):
        vertices, faces = icosphere(3)
        obj = add_selected(vertices, faces)
        write_absolute_keys(obj, [factor * vertices])
        show("REMOVED")
        return obj

    def test_it_is_the_way_along_the_normal_positive_where_a_bump_was_taken_off(self, obj, factor):
        removed = numbers(obj.data, "fairing_removed")
        assert removed == pytest.approx(1.0 - factor, abs=1e-4)

    def test_bumps_are_red_and_dents_blue_and_zero_is_in_the_middle(self, obj, factor):
        attribute = obj.data.color_attributes["fairing_removed_color"]
        colors = np.array([each.color[:3] for each in attribute.data])
        assert (np.sign(colors[:, 0] - colors[:, 2]) == np.sign(1.0 - factor)).all()
        low, high = obj.adaptive_fairing.view_range
        assert low == -high
        assert high == pytest.approx(0.1, abs=1e-4)

    def test_moves_within_the_surface_remove_nothing(self):
        vertices, faces = flat_hexagon(4)
        obj = add_selected(vertices, faces)
        write_absolute_keys(obj, [0.8 * vertices])
        show("REMOVED")
        assert numbers(obj.data, "fairing_removed") == pytest.approx(0.0, abs=1e-6)

    def test_it_follows_the_slider_and_is_for_every_scheme(self):
        obj = add_selected(*icosphere(2))
        for scheme in ("UNIFORM", "TENSOR"):
            bpy.ops.object.adaptive_fairing(algorithm="FAIR", scheme=scheme, steps=2, tau=0.01)
            show("REMOVED")
            whole = numbers(obj.data, "fairing_removed")
            assert (whole > 0).all()
            obj.adaptive_fairing.evolution = 0.0
            show("REMOVED")
            assert not numbers(obj.data, "fairing_removed").any()


class TestFinalShapeOnly:
    """No shape key holds the mesh before: only the run itself knows what it has changed."""

    @pytest.fixture
    def obj(self):
        return add_selected(*icosphere(2))

    def run(self):
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2, tau=0.01, output="FINAL_SHAPE")

    @pytest.mark.parametrize("field", ["DISPLACEMENT", "REMOVED"])
    def test_a_run_ends_a_view_that_has_nothing_to_compare_with(self, obj, field):
        show(field)
        self.run()
        assert obj.adaptive_fairing.view == ""
        assert f"fairing_{field.lower()}" not in obj.data.attributes

    @pytest.mark.parametrize("field", ["DISPLACEMENT", "REMOVED"])
    def test_later_it_is_said_that_there_is_nothing_to_compare_with(self, obj, field):
        self.run()
        with pytest.raises(InputError, match="the shape before the smoothing was not kept"):
            measure_field(obj, field, FairingSettings())
        assert show(field) == {"CANCELLED"}
        assert obj.adaptive_fairing.view == ""

    @pytest.mark.parametrize("field", ["DENSITY", "CURVATURE", "GAUSSIAN"])
    def test_other_fields_need_nothing_to_compare_with(self, obj, field):
        self.run()
        assert show(field) == {"FINISHED"}


class TestOtherFields:
    def test_displacement_is_measured_from_the_undeformed_mesh_to_the_shown_one(self):
        obj = add_selected(*icosphere(2))
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=4, tau=0.05)
        for evolution in (0.3, 1.0):
            obj.adaptive_fairing.evolution = evolution
            show("DISPLACEMENT")
            moved = np.linalg.norm(shown_positions(obj) - icosphere(2)[0], axis=1)
            assert numbers(obj.data, "fairing_displacement") == pytest.approx(moved, abs=2e-7)

    def test_displacement_of_relative_keys(self):
        obj = add_selected(*icosphere(2))
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2, tau=0.05, output="RELATIVE_KEYS")
        blocks = obj.data.shape_keys.key_blocks
        blocks["Fairing 1"].value, blocks["Fairing 2"].value = 0.25, 0.5
        show("DISPLACEMENT")
        moved = np.linalg.norm(shown_positions(obj) - icosphere(2)[0], axis=1)
        assert numbers(obj.data, "fairing_displacement") == pytest.approx(moved, abs=2e-7)

    @pytest.mark.parametrize("kind", ["edge", "area"])
    def test_density_before_a_run_is_the_one_its_first_step_uses(self, kind):
        vertices, faces = ellipsoid(2, (1.0, 2.0, 3.0))
        bpy.context.scene.adaptive_fairing.density = kind.upper()
        obj = add_selected(vertices, faces)
        show("DENSITY")
        expected = (
            fair(np.float32(vertices), faces, FairingSettings(density=DENSITIES[kind]))
            .steps[0]
            .density
        )
        assert numbers(obj.data, "fairing_density") == pytest.approx(expected, rel=1e-6)

    def test_a_cut_in_the_surface_is_no_obstacle(self):
        vertices, faces = icosphere(1)
        obj = add_selected(
            np.concatenate([vertices, [[2.0, 2, 2]]]), [*faces.tolist(), [*faces[0][:2], 42]]
        )
        assert show("DENSITY") == {"FINISHED"}
        assert np.isfinite(numbers(obj.data, "fairing_density")).all()

    def test_no_faces_is_said(self):
        add_selected([[0, 0, 0], [1, 0, 0]], [])
        assert show("DENSITY") == {"CANCELLED"}

    def test_settings_without_sense_are_said(self):
        add_selected(*icosphere(1))
        settings = bpy.context.scene.adaptive_fairing
        settings.use_tau, settings.tau = True, 0.0
        with pytest.raises(RuntimeError, match="tau must be"):
            show("DENSITY")


class TestLegend:
    def test_it_has_the_ends_of_the_colours(self):
        obj = add_selected(*ellipsoid(3, (1.0, 2.0, 3.0)))
        show("CURVATURE")
        values = numbers(obj.data, "fairing_mean_curvature")
        record = obj.adaptive_fairing
        assert record.view == "CURVATURE"
        high = np.percentile(np.abs(values), 90)
        assert list(record.view_range) == pytest.approx([-high, high], rel=1e-2)
        assert "fairing_mean_curvature_color" in obj.data.color_attributes

    def test_a_few_wild_values_do_not_set_the_range(self):
        values = np.linspace(0.0, 1.0, 1001)
        values[0], values[1] = 1e6, np.nan
        low, high = color_range(values)
        assert 0.0 < low < 0.02
        assert 0.98 < high < 1.01

    def test_a_run_colours_the_new_shape_anew(self):
        obj = add_selected(*ellipsoid(2, (1.0, 2.0, 3.0)))
        show("DISPLACEMENT")
        assert list(obj.adaptive_fairing.view_range) == [0.0, 0.0]
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2)
        assert obj.adaptive_fairing.view == "DISPLACEMENT"
        assert obj.adaptive_fairing.view_range[1] > 0.0
        moved = np.linalg.norm(shown_positions(obj) - ellipsoid(2, (1.0, 2.0, 3.0))[0], axis=1)
        assert numbers(obj.data, "fairing_displacement") == pytest.approx(moved, abs=1e-6)
        assert "fairing_displacement_color" in obj.data.color_attributes

    @pytest.mark.parametrize("field", FIELD_ATTRIBUTES)
    def test_the_end_of_the_view_leaves_nothing(self, field):
        obj = add_selected(*icosphere(2))
        names = obj.data.attributes.keys()
        show(field)
        assert len(obj.data.attributes) == len(names) + 2
        bpy.ops.object.adaptive_fairing_view_end()
        assert obj.adaptive_fairing.view == ""
        assert obj.data.attributes.keys() == names

    def test_one_field_takes_the_place_of_another(self):
        obj = add_selected(*icosphere(2))
        show("CURVATURE")
        show("DISPLACEMENT")
        assert "fairing_mean_curvature" not in obj.data.attributes

    def test_the_density_of_a_run_stays(self):
        obj = add_selected(*icosphere(2))
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
        show("DENSITY")
        bpy.ops.object.adaptive_fairing_view_end()
        assert {"fairing_density", "fairing_density_color"} <= set(obj.data.attributes.keys())

    def test_it_follows_the_strength(self):
        vertices, faces = noisy_ball(3, 0.02)
        obj = add_selected(vertices, faces)
        bpy.ops.object.adaptive_fairing()
        show("DISPLACEMENT")
        for strength in (0.0, 0.5, 1.5):
            obj.adaptive_fairing.strength = strength
            moved = np.linalg.norm(shown_positions(obj) - np.float32(vertices), axis=1)
            assert numbers(obj.data, "fairing_displacement") == pytest.approx(moved, abs=1e-6)


def test_edit_mode_is_left_and_entered_again():
    obj = add_selected(*icosphere(1))
    bpy.ops.object.mode_set(mode="EDIT")
    show("DENSITY")
    assert obj.mode == "EDIT"
