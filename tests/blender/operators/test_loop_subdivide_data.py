"""Loop subdivision of objects: everything that lies on the mesh goes along."""

import bpy
import numpy as np
import pytest
from support import meshes
from support.objects import (
    add_object,
    add_rich_object,
    colors_by_vertex,
    corners,
    key_positions,
    numbers,
)
from support.subdivision import bent_boundary, edges_of, sphere, subdivide, surface_of, values_of

from adaptive_fairing.blender.data.mesh_arrays import read_positions

pytestmark = pytest.mark.usefixtures("addon")


class TestAttributes:
    @pytest.mark.parametrize("domain", ["POINT", "CORNER"])
    @pytest.mark.parametrize(
        ("data_type", "name", "width"),
        [
            ("FLOAT", "value", 1),
            ("FLOAT2", "vector", 2),
            ("FLOAT_VECTOR", "vector", 3),
            ("FLOAT_COLOR", "color", 4),
            ("QUATERNION", "value", 4),
        ],
    )
    def test_numbers_are_interpolated_linearly(self, domain, data_type, name, width):
        """A linear function of the place on the control mesh stays that function."""
        obj = add_rich_object()
        mesh, rng = obj.data, np.random.default_rng(4)
        factors = rng.normal(size=(3, width))
        place = read_positions(mesh)
        place = place if domain == "POINT" else place[corners(mesh)]
        attribute = mesh.attributes.new("mine", data_type, domain)
        attribute.data.foreach_set(name, (place @ factors).astype(np.float32).ravel())
        carried = mesh.attributes.new("place", "FLOAT_VECTOR", domain)
        carried.data.foreach_set("vector", place.astype(np.float32).ravel())
        subdivide(obj, levels=2)
        found = values_of(obj.data, "mine").reshape(-1, width)
        expected = values_of(obj.data, "place") @ factors
        np.testing.assert_allclose(found, expected, atol=1e-5)

    def test_uv_maps(self):
        """A UV map that is the place: at every corner where the control mesh has it."""
        obj = add_object(*meshes.flat_grid(3, 2))
        mesh = obj.data
        for name in ("First", "Second"):
            layer = mesh.uv_layers.new(name=name)
            places = read_positions(mesh)[corners(mesh), :2]
            layer.uv.foreach_set("vector", places.astype(np.float32).ravel())
        mesh.uv_layers.active_index = 1
        mesh.uv_layers["First"].active_render = True
        place = mesh.attributes.new("place", "FLOAT_VECTOR", "POINT")
        place.data.foreach_set("vector", read_positions(mesh).astype(np.float32).ravel())
        subdivide(obj, levels=2)
        new = obj.data
        assert [layer.name for layer in new.uv_layers] == ["First", "Second"]
        assert new.uv_layers.active.name == "Second" and new.uv_layers["First"].active_render
        by_corner = values_of(new, "place")[corners(new), :2]
        np.testing.assert_allclose(values_of(new, "First"), by_corner, atol=1e-6)

    def test_seams_of_a_uv_map_stay_apart(self):
        """Two triangles of a quad with UVs of their own: no value of one gets into the other."""
        obj = add_object([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)])
        layer = obj.data.uv_layers.new(name="UV")
        layer.uv.foreach_set("vector", np.repeat([0.0, 10.0], 6).astype(np.float32))
        subdivide(obj, levels=2)
        assert set(values_of(obj.data, "UV").reshape(2, -1)[0]) == {0.0}
        assert set(values_of(obj.data, "UV").reshape(2, -1)[1]) == {10.0}

    def test_colors(self):
        obj = add_rich_object()
        before = colors_by_vertex(obj.data, "Paint")
        subdivide(obj)
        assert np.array_equal(colors_by_vertex(obj.data, "Paint")[: len(before)], before)
        assert obj.data.color_attributes.active_color.name == "Paint"
        assert obj.data.attributes["Paint"].data_type == "BYTE_COLOR"

    def test_points_keep_their_numbers(self):
        obj = add_rich_object()
        before = numbers(obj.data, "heat")
        subdivide(obj)
        assert np.array_equal(numbers(obj.data, "heat")[: len(before)], before)

    def test_whole_numbers_flags_and_texts_of_points(self):
        obj = add_object([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
        mesh = obj.data
        mesh.attributes.new("count", "INT", "POINT").data.foreach_set("value", [1, 3, 7])
        mesh.attributes.new("flag", "BOOLEAN", "POINT").data.foreach_set("value", [1, 1, 0])
        text = mesh.attributes.new("text", "STRING", "POINT")
        for item, value in zip(text.data, (b"a", b"b", b"c"), strict=True):
            item.value = value
        ends = [(0, 1), (1, 2), (2, 0)]
        subdivide(obj)
        new = obj.data
        assert values_of(new, "count").tolist() == [1, 3, 7, 2, 5, 4]
        assert values_of(new, "flag").tolist() == [True, True, False, True, False, False]
        words = values_of(new, "text").tolist()
        assert words[:3] == [b"a", b"b", b"c"]
        for word, (a, b) in zip(words[3:], ends, strict=True):
            assert word in (words[a], words[b])

    @pytest.mark.parametrize("data_type", ["INT", "INT8", "FLOAT", "BOOLEAN", "STRING"])
    def test_faces_inherit(self, data_type):
        obj = add_rich_object()
        mesh = obj.data
        mesh.calc_loop_triangles()
        polygon_of = [t.polygon_index for t in mesh.loop_triangles]
        attribute = mesh.attributes.new("mine", data_type, "FACE")
        values = [
            index % (2 if data_type == "BOOLEAN" else 100) for index in range(len(mesh.polygons))
        ]
        if data_type == "STRING":
            values = [str(value).encode() for value in values]
        for item, value in zip(attribute.data, values, strict=True):
            item.value = value
        subdivide(obj)
        expected = [values[polygon] for polygon in polygon_of for _ in range(4)]
        assert values_of(obj.data, "mine").tolist() == expected

    def test_materials(self):
        obj = add_rich_object()
        mesh = obj.data
        mesh.calc_loop_triangles()
        expected = [t.material_index for t in mesh.loop_triangles for _ in range(16)]
        subdivide(obj, levels=2)
        assert [material.name for material in obj.data.materials] == ["Red", "Blue"]
        assert [polygon.material_index for polygon in obj.data.polygons] == expected

    @pytest.mark.parametrize("flag", ["use_seam", "use_edge_sharp"])
    def test_halves_of_edges_inherit(self, flag):
        obj = sphere()
        marked = {tuple(sorted(edge)) for edge in bent_boundary().tolist()}
        for edge in obj.data.edges:
            setattr(edge, flag, tuple(sorted(edge.vertices)) in marked)
        n = len(obj.data.vertices)
        subdivide(obj)
        ends = edges_of(obj.data)
        found = ends[[getattr(edge, flag) for edge in obj.data.edges]]
        assert len(found) == 2 * len(marked)
        middles = {}
        for a, b in np.sort(found, axis=1).tolist():
            assert a < n <= b
            middles.setdefault(b, []).append(a)
        assert {tuple(sorted(pair)) for pair in middles.values()} == marked

    def test_numbers_of_edges(self):
        """Creases, bevel weights and an attribute of one's own; diagonals have none."""
        obj = add_rich_object()
        mesh = obj.data
        rng = np.random.default_rng(1)
        for name in ("crease_edge", "bevel_weight_edge", "mine"):
            attribute = mesh.attributes.new(name, "FLOAT", "EDGE")
            values = 0.1 + 0.5 * rng.random(len(mesh.edges), dtype=np.float32)
            attribute.data.foreach_set("value", values)
        expected = {
            n: np.sort(values_of(mesh, n)) for n in ("crease_edge", "bevel_weight_edge", "mine")
        }
        subdivide(obj)
        for name, values in expected.items():
            found = values_of(obj.data, name)
            assert np.array_equal(np.sort(found[found > 0]), np.repeat(values, 2))

    def test_nothing_of_the_refined_mesh_is_selected_and_hidden_parts_stay_hidden(self):
        obj = sphere()
        obj.data.polygons[3].hide = True
        subdivide(obj)
        hidden = [index for index, polygon in enumerate(obj.data.polygons) if polygon.hide]
        assert hidden == [12, 13, 14, 15]


class TestVertexGroups:
    def test_weights_are_linear_and_members_spread_half_way(self):
        obj = add_object([(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 5)], [(0, 1, 2)])
        group = obj.vertex_groups.new(name="Arm")
        group.add([0], 0.5, "REPLACE")
        group.add([1], 0.0, "REPLACE")
        obj.vertex_groups.new(name="Locked").lock_weight = True
        obj.vertex_groups["Locked"].add([2, 3], 1.0, "REPLACE")
        obj.vertex_groups.active_index = 0
        subdivide(obj)
        assert [g.name for g in obj.vertex_groups] == ["Arm", "Locked"]
        assert [g.lock_weight for g in obj.vertex_groups] == [False, True]
        assert obj.vertex_groups.active_index == 0
        members = [
            {g.group: round(g.weight, 6) for g in vertex.groups} for vertex in obj.data.vertices
        ]
        # Vertices 0 to 3, then the middles of (0, 1), (1, 2), (2, 0).
        assert members == [
            {0: 0.5}, {0: 0.0}, {1: 1.0}, {1: 1.0}, {0: 0.25}, {0: 0.0, 1: 0.5}, {0: 0.25, 1: 0.5},
        ]  # fmt: skip


class TestShapeKeys:
    def keyed(self):
        obj = sphere()
        base = read_positions(obj.data)
        obj.shape_key_add(name="Basis", from_mix=False)
        for index, name in enumerate(("Long", "Wide", "Odd")):
            block = obj.shape_key_add(name=name, from_mix=False)
            block.points.foreach_set("co", (base * (1, 1 + index, 2)).astype(np.float32).ravel())
        return obj

    def test_every_key_is_refined_on_its_own(self):
        obj = self.keyed()
        surface = surface_of(obj)
        names = [block.name for block in obj.data.shape_keys.key_blocks]
        expected = {
            name: surface.moved(key_positions(obj, name)).refined(1).vertices for name in names
        }
        subdivide(obj)
        assert [block.name for block in obj.data.shape_keys.key_blocks] == names
        for name in names:
            np.testing.assert_allclose(key_positions(obj, name), expected[name], atol=1e-6)

    def test_settings_of_the_keys_stay(self):
        obj = self.keyed()
        blocks = obj.data.shape_keys.key_blocks
        blocks["Long"].value, blocks["Wide"].mute = 0.25, True
        blocks["Odd"].slider_min, blocks["Odd"].slider_max = -2.0, 3.0
        blocks["Odd"].relative_key, blocks["Odd"].interpolation = blocks["Wide"], "KEY_CARDINAL"
        obj.vertex_groups.new(name="Mask")
        blocks["Odd"].vertex_group = "Mask"
        obj.active_shape_key_index, obj.show_only_shape_key = 2, True
        subdivide(obj)
        blocks = obj.data.shape_keys.key_blocks
        assert blocks["Long"].value == 0.25 and blocks["Wide"].mute
        assert (blocks["Odd"].slider_min, blocks["Odd"].slider_max) == (-2.0, 3.0)
        assert blocks["Odd"].relative_key == blocks["Wide"]
        assert blocks["Odd"].interpolation == "KEY_CARDINAL"
        assert blocks["Odd"].vertex_group == "Mask"
        assert obj.active_shape_key_index == 2 and obj.show_only_shape_key

    def test_absolute_keys_stand_at_the_same_times(self):
        """A deleted key leaves a gap, which the animation counts on."""
        obj = self.keyed()
        obj.data.shape_keys.use_relative = False
        obj.shape_key_remove(obj.data.shape_keys.key_blocks["Long"])
        keys = obj.data.shape_keys
        keys.eval_time = 12.5
        frames = [block.frame for block in keys.key_blocks]
        keys.keyframe_insert("eval_time", frame=7)
        action = keys.animation_data.action
        subdivide(obj)
        keys = obj.data.shape_keys
        assert frames == [0.0, 20.0, pytest.approx(30)]
        assert [block.frame for block in keys.key_blocks] == frames
        assert not keys.use_relative and keys.eval_time == 12.5
        assert keys.animation_data.action == action
        bpy.context.scene.frame_set(9)
        assert keys.eval_time == 12.5

    def test_drivers_stay(self):
        obj = self.keyed()
        curve = obj.data.shape_keys.key_blocks["Long"].driver_add("value")
        curve.driver.expression = "0.75"
        subdivide(obj)
        drivers = obj.data.shape_keys.animation_data.drivers
        assert [d.data_path for d in drivers] == ['key_blocks["Long"].value']
        bpy.context.view_layer.update()
        assert obj.data.shape_keys.key_blocks["Long"].value == pytest.approx(0.75)

    def test_no_key_is_left_behind(self):
        obj = self.keyed()
        subdivide(obj)
        assert [key.user for key in bpy.data.shape_keys if key.users] == [obj.data]
