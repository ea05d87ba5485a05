"""Limit positions, and control points whose limit surface runs close by."""

import numpy as np
import pytest
from support import meshes
from support.reference import subdivision_matrix

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.mesh.limit_surface import (
    INVERSE_TERMS,
    limit_matrix,
    near_control_points,
)

CASES = {
    "tetrahedron": meshes.tetrahedron(),
    "valences 3 to 10": meshes.random_closed(1),
    "pole of valence 44": meshes.bipyramid(44),
    "open, irregular": meshes.bumpy_disc(0),
    "two components": meshes.merged(meshes.octahedron(), meshes.open_cylinder(5, 2)),
}


def matrix_of(mesh):
    return limit_matrix(TriangleTopology(mesh[1], len(mesh[0])))


@pytest.mark.parametrize("name", CASES)
def test_subdivision_does_not_change_the_limit(name):
    """The one matrix of averages over the neighbours with this property: P_fine S = P."""
    vertices, faces = CASES[name]
    subdivision, fine_faces = subdivision_matrix(faces, len(vertices))
    finer = matrix_of((np.empty((subdivision.shape[0], 3)), fine_faces))
    difference = (finer @ subdivision)[: len(vertices)] - matrix_of(CASES[name])
    assert abs(difference).max() < 1e-14


@pytest.mark.parametrize("name", CASES)
def test_rows_are_averages(name):
    matrix = matrix_of(CASES[name])
    assert matrix.data.min() >= 0
    np.testing.assert_allclose(matrix.sum(axis=1), 1, rtol=1e-14)


def test_loose_vertices_stay():
    vertices, faces = meshes.octahedron()
    loose = np.vstack([vertices, [[7.0, 8.0, 9.0]]])
    assert np.array_equal((matrix_of((loose, faces)) @ loose)[-1], [7.0, 8.0, 9.0])


@pytest.mark.parametrize("name", CASES)
def test_what_the_near_control_points_miss_is_a_power_of_what_one_limit_step_misses(name):
    """P Σ (I - P)^k x = x - (I - P)^m x for the first m terms."""
    mesh = CASES[name]
    matrix, missed = matrix_of(mesh), mesh[0]
    for _ in range(INVERSE_TERMS):
        missed = missed - matrix @ missed
    surface = matrix @ near_control_points(matrix, mesh[0])
    np.testing.assert_allclose(surface, mesh[0] - missed, atol=1e-13)
