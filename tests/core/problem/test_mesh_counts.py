"""Counts of parts, boundaries and crowded edges, on meshes where they are known."""

import numpy as np
import pytest
from support import bad_meshes, meshes

from adaptive_fairing.core.problem.mesh_counts import MeshCounts, mesh_counts


def counted(mesh):
    return mesh_counts(np.asarray(mesh[1], dtype=np.int32))


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (meshes.tetrahedron(), MeshCounts(1, 1.0, 0, 0)),
        (meshes.single_triangle(), MeshCounts(1, 1.0, 1, 0)),
        (meshes.flat_grid(3, 4), MeshCounts(1, 1.0, 1, 0)),
        (meshes.open_cylinder(8, 3), MeshCounts(1, 1.0, 2, 0)),
        (meshes.torus(7, 5), MeshCounts(1, 1.0, 0, 0)),
        (meshes.merged(meshes.tetrahedron(), meshes.octahedron()), MeshCounts(2, 8 / 12, 0, 0)),
        (bad_meshes.moebius_strip(), MeshCounts(1, 1.0, 1, 0)),
        (bad_meshes.klein_bottle(), MeshCounts(1, 1.0, 0, 0)),
    ],
)
def test_a_mesh_has_what_its_shape_says(mesh, expected):
    assert counted(mesh) == expected


def test_edges_of_three_sheets_are_crowded():
    vertices, faces = bad_meshes.three_sheets(3)
    edges = {}
    for face in np.asarray(faces).tolist():
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            edges[frozenset((a, b))] = edges.get(frozenset((a, b)), 0) + 1
    crowded = sum(uses > 2 for uses in edges.values())
    assert crowded > 0
    assert counted((vertices, faces)).n_crowded_edges == crowded


def test_holes_are_counted_one_by_one():
    vertices, faces = meshes.noisy_ball(2, 0.0)
    apart = [0]
    for index, face in enumerate(faces):
        if len(apart) < 3 and not np.isin(face, faces[apart]).any():
            apart.append(index)
    assert counted((vertices, np.delete(faces, apart, axis=0))).n_boundaries == 3


def test_the_numbering_does_not_matter():
    vertices, faces = meshes.merged(meshes.open_cylinder(8, 3), meshes.flat_grid(3, 4))
    order = np.random.default_rng(0).permutation(len(vertices))
    shuffled = np.random.default_rng(1).permutation(order[faces])
    assert counted((vertices, shuffled)) == counted((vertices, faces))
