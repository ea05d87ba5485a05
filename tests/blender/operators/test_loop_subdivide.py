"""Loop subdivision of objects: geometry of the core, and everything that lies on the mesh."""

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree
from support import bad_meshes, meshes
from support.objects import (
    add_object,
    add_rich_object,
    colors_by_vertex,
    corners,
    everything,
    key_positions,
    numbers,
)

from adaptive_fairing.blender.data import refinements
from adaptive_fairing.blender.data.attribute_arrays import read_attributes
from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.core import LimitSurface, TriangleTopology
from adaptive_fairing.core.surface import memory_estimate
from adaptive_fairing.core.surface.limit_surface import RefinementLevels

pytestmark = pytest.mark.usefixtures("addon")


def subdivide(obj, **options):
    """Run the operator on one object."""
    for other in bpy.context.scene.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj
    return bpy.ops.object.adaptive_fairing_loop_subdivide(**options)


def sphere():
    return add_object(*meshes.random_closed(1))


def surface_of(obj, **options):
    data = read_mesh(obj.data)
    return LimitSurface(
        TriangleTopology(data.triangles, len(data.vertices)), data.vertices, **options
    )


def values_of(mesh, name):
    return next(a.values for a in read_attributes(mesh) if a.name == name)


def edges_of(mesh):
    ends = np.empty(2 * len(mesh.edges), dtype=np.int32)
    mesh.edges.foreach_get("vertices", ends)
    return ends.reshape(-1, 2)


def normals_of(mesh):
    flat = np.empty(3 * len(mesh.loops), dtype=np.float32)
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()
    mesh.corner_normals.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def bent_boundary():
    """Return the index pairs of three edges in a row on the sphere."""
    faces = meshes.random_closed(1)[1]
    return meshes.edges_of(faces)[:7]


class TestGeometry:
    @pytest.mark.parametrize("levels", [1, 2, 3])
    def test_positions_and_triangles_are_the_cores(self, levels):
        obj = sphere()
        refined = surface_of(obj).refined(levels)
        assert subdivide(obj, levels=levels) == {"FINISHED"}
        assert np.array_equal(
            read_positions(obj.data), refined.vertices.astype(np.float32).astype(np.float64)
        )
        found = np.array([list(polygon.vertices) for polygon in obj.data.polygons])
        assert np.array_equal(found, refined.triangles)

    def test_control_points_on_request(self):
        obj = sphere()
        surface = surface_of(obj)
        expected = surface.refinement_matrix(1) @ surface.positions
        subdivide(obj, on_limit=False)
        np.testing.assert_allclose(read_positions(obj.data), expected, atol=1e-7)

    def test_two_steps_without_limit_are_one_step_twice(self):
        once, twice = sphere(), sphere()
        subdivide(once, levels=2, on_limit=False)
        subdivide(twice, on_limit=False)
        subdivide(twice, on_limit=False)
        distance, other = cKDTree(read_positions(once.data)).query(read_positions(twice.data))
        assert distance.max() < 1e-6 and len(np.unique(other)) == len(once.data.vertices)

    @pytest.mark.parametrize("levels", [1, 2])
    def test_blender_finds_nothing_to_mend(self, levels):
        for mesh in (meshes.random_closed(1), meshes.bumpy_disc(0), bad_meshes.three_sheets()):
            obj = add_object(*mesh)
            subdivide(obj, levels=levels)
            assert not obj.data.validate(verbose=True)

    def test_polygons_become_triangles_in_the_refined_mesh_only(self):
        obj = add_rich_object()
        mesh = obj.data
        n_triangles = len(read_mesh(mesh).triangles)
        sizes = [len(polygon.vertices) for polygon in mesh.polygons]
        mesh.use_fake_user = True
        subdivide(obj)
        assert len(obj.data.polygons) == 4 * n_triangles
        assert [len(polygon.vertices) for polygon in mesh.polygons] == sizes

    def test_loose_vertices_and_edges_stay(self):
        vertices, faces = meshes.octahedron()
        vertices = np.vstack([vertices, [(3, 0, 0), (4, 0, 0), (5, 5, 5)]])
        mesh = bpy.data.meshes.new("Loose")
        mesh.from_pydata(vertices.tolist(), [(6, 7)], faces.tolist())
        obj = bpy.data.objects.new("Loose", mesh)
        bpy.context.scene.collection.objects.link(obj)
        subdivide(obj)
        assert np.array_equal(read_positions(obj.data)[6:9], vertices[6:])
        assert (6, 7) in {tuple(edge.vertices) for edge in obj.data.edges}
        assert not obj.data.validate(verbose=True)

    def test_non_manifold_meshes_stay_joined(self):
        obj = add_object(*bad_meshes.three_sheets())
        subdivide(obj)
        assert len(obj.data.vertices) == len(np.unique(read_positions(obj.data), axis=0))
        assert len(obj.data.polygons) == 4 * len(bad_meshes.three_sheets()[1])


class TestCreases:
    @pytest.mark.parametrize("mark", ["sharp", "crease"])
    def test_a_cube_with_marked_edges_stays_a_cube(self, mark):
        bpy.ops.mesh.primitive_cube_add(size=2)
        obj = bpy.context.active_object
        mesh = obj.data
        if mark == "sharp":
            for edge in mesh.edges:
                edge.use_edge_sharp = True
        else:
            crease = mesh.attributes.new("crease_edge", "FLOAT", "EDGE")
            crease.data.foreach_set("value", np.ones(12, dtype=np.float32))
        subdivide(obj, levels=2)
        positions = read_positions(obj.data)
        assert np.abs(positions).max() == 1
        assert (np.abs(np.abs(positions).max(axis=1) - 1) < 1e-6).all()
        # One flat normal a face, at every corner.
        normals = normals_of(obj.data)
        polygons = np.array([tuple(p.normal) for p in obj.data.polygons])
        np.testing.assert_allclose(
            normals.reshape(-1, 3, 3), np.repeat(polygons[:, None], 3, 1), atol=1e-4
        )

    def test_marks_can_be_ignored(self):
        plain, marked = sphere(), sphere()
        for edge in marked.data.edges:
            edge.use_edge_sharp = True
        subdivide(plain)
        subdivide(marked, sharp_creases=False)
        assert np.array_equal(read_positions(plain.data), read_positions(marked.data))

    def test_vertices_with_a_crease_stay(self):
        obj = sphere()
        before = read_positions(obj.data)
        weights = np.zeros(len(before), dtype=np.float32)
        weights[[3, 8]] = 1.0
        obj.data.attributes.new("crease_vert", "FLOAT", "POINT").data.foreach_set("value", weights)
        subdivide(obj)
        stays = (read_positions(obj.data)[: len(before)] == before).all(axis=1)
        assert np.flatnonzero(stays).tolist() == [3, 8]


class TestNormals:
    @pytest.mark.parametrize("keys", [False, True])
    def test_exact_normals_shade_the_mesh(self, keys):
        """Stored as vectors, or by angles, of 16 bits, where keys move the mesh."""
        obj = sphere()
        expected = surface_of(obj).refined(2)
        if keys:
            obj.shape_key_add(name="Basis")
        subdivide(obj, levels=2)
        assert obj.data.has_custom_normals
        shown = normals_of(obj.data)
        wanted = expected.normals[corners(obj.data)]
        assert np.abs(shown - wanted).max() < 1e-3
        # Blender's own average is another one: that is what would be shown without.
        plain = sphere()
        subdivide(plain, levels=2, exact_normals=False)
        assert not plain.data.has_custom_normals
        assert np.abs(normals_of(plain.data) - wanted).max() > 1e-2

    def test_shading_is_smooth(self):
        obj = sphere()
        obj.data.shade_flat()
        subdivide(obj)
        assert all(polygon.use_smooth for polygon in obj.data.polygons)


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


class TestOwnership:
    def test_a_shared_mesh_stays_and_the_object_gets_its_own(self):
        obj = sphere()
        mesh = obj.data
        other = bpy.data.objects.new("Other", mesh)
        bpy.context.scene.collection.objects.link(other)
        before = read_positions(mesh)
        subdivide(obj)
        assert other.data == mesh and obj.data != mesh
        assert np.array_equal(read_positions(mesh), before)

    def test_an_only_mesh_is_replaced_under_its_name(self):
        obj = sphere()
        obj.data["mine"] = 5
        name = obj.data.name
        subdivide(obj)
        assert obj.data.name == name and len(bpy.data.meshes) == 1
        assert obj.data["mine"] == 5

    def test_all_selected_objects_are_refined(self):
        objects = [sphere(), sphere(), sphere()]
        for obj in objects[:2]:
            obj.select_set(True)
        objects[2].select_set(False)
        bpy.ops.object.adaptive_fairing_loop_subdivide()
        assert [len(obj.data.polygons) for obj in objects] == [320, 320, 80]


class TestOperator:
    def test_in_edit_mode(self):
        obj = sphere()
        obj.select_set(True)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.object.adaptive_fairing_loop_subdivide()
        assert obj.mode == "EDIT"
        bpy.ops.object.mode_set(mode="OBJECT")
        assert len(obj.data.polygons) == 320

    def test_nothing_selected(self):
        with pytest.raises(RuntimeError, match="Select a mesh object"):
            bpy.ops.object.adaptive_fairing_loop_subdivide()

    def test_no_faces(self):
        obj = add_object([(0, 0, 0), (1, 0, 0)], [])
        with pytest.raises(RuntimeError, match="no faces: there is no surface to refine"):
            subdivide(obj)
        assert len(obj.data.vertices) == 2

    def test_what_was_cut_is_said(self):
        obj = add_object(*bad_meshes.three_sheets())
        assert subdivide(obj) == {"FINISHED"}

    def test_what_does_not_fit_into_memory_is_refused_with_the_numbers(self, monkeypatch):
        obj = sphere()
        n = len(obj.data.polygons)
        monkeypatch.setattr(memory_estimate, "available_bytes", lambda: 60_000_000)
        message = f"{64 * n} refined triangles need about 0.1 GB of memory, 0.1 GB are available"
        monkeypatch.setattr(memory_estimate, "BYTES_PER_TRIANGLE", 2_000)
        with pytest.raises(RuntimeError, match=message):
            subdivide(obj, levels=3)
        assert len(obj.data.polygons) == n
        assert subdivide(obj, levels=1) == {"FINISHED"}


class TestTheRedoPanel:
    """The same mesh again, with other options."""

    def again(self, **options):
        obj = sphere()
        subdivide(obj, **options)
        return everything(obj)

    def test_what_is_known_is_not_computed_and_the_same(self, monkeypatch):
        refinements.forget()
        first = self.again(levels=2)
        with monkeypatch.context() as patch:
            patch.setattr(refinements, "cut_surface", None)  # would fail if they were called
            patch.setattr(RefinementLevels, "points_and_normals", None)
            assert self.again(levels=2) == first
        with monkeypatch.context() as patch:
            patch.setattr(refinements, "cut_surface", None)
            others = {"levels": 3}, {"on_limit": False}, {"exact_normals": False}
            found = [self.again(**each) for each in others]
        refinements.forget()
        for options, values in zip(others, found, strict=True):
            refinements.forget()
            assert self.again(**options) == values

    @pytest.mark.parametrize("change", ["move", "crease", "turn"])
    def test_another_mesh_is_refined_anew(self, change):
        results = []
        for is_known in (True, False):
            refinements.forget()
            if is_known:
                self.again(levels=1)
            obj = sphere()
            if change == "move":
                obj.data.vertices[3].co.x += 0.1
            elif change == "crease":
                obj.data.edges[5].use_edge_sharp = obj.data.edges[6].use_edge_sharp = True
            else:
                obj.data.flip_normals()
            subdivide(obj)
            results.append(everything(obj))
        assert results[0] == results[1]

    def test_nothing_is_kept_of_a_large_mesh(self, monkeypatch):
        monkeypatch.setattr(refinements, "LARGEST_KEPT", 100)
        refinements.forget()
        self.again(levels=1)
        assert refinements._last == []
