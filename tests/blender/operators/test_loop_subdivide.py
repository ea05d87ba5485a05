"""Loop subdivision of objects: geometry, creases, normals, who owns the mesh, the operator."""

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree
from support import bad_meshes, meshes
from support.objects import add_object, add_rich_object, corners, everything
from support.subdivision import normals_of, sphere, subdivide, surface_of

from adaptive_fairing.blender.data import refinement_cache
from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.core.surface import memory_estimate
from adaptive_fairing.core.surface.limit_surface import RefinementLevels

pytestmark = pytest.mark.usefixtures("addon")


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
        refinement_cache.forget()
        first = self.again(levels=2)
        with monkeypatch.context() as patch:
            patch.setattr(refinement_cache, "cut_surface", None)  # would fail if they were called
            patch.setattr(RefinementLevels, "points_and_normals", None)
            assert self.again(levels=2) == first
        with monkeypatch.context() as patch:
            patch.setattr(refinement_cache, "cut_surface", None)
            others = {"levels": 3}, {"on_limit": False}, {"exact_normals": False}
            found = [self.again(**each) for each in others]
        refinement_cache.forget()
        for options, values in zip(others, found, strict=True):
            refinement_cache.forget()
            assert self.again(**options) == values

    @pytest.mark.parametrize("change", ["move", "crease", "turn"])
    def test_another_mesh_is_refined_anew(self, change):
        results = []
        for is_known in (True, False):
            refinement_cache.forget()
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
        monkeypatch.setattr(refinement_cache, "LARGEST_KEPT", 100)
        refinement_cache.forget()
        self.again(levels=1)
        assert refinement_cache._last == []
