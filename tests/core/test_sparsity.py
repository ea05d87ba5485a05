"""Places of pairs in the sparsity pattern: looked up in a table, or searched for."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology, sparsity
from adaptive_fairing.core.sparsity import SymmetricPattern, scattered

CASES = [
    pytest.param(mesh, id=name)
    for name, mesh in {
        "tetrahedron": meshes.tetrahedron(),
        "valences 3 to 10": meshes.random_closed(1),
        "open": meshes.bumpy_disc(0),
        "pole of valence 44": meshes.latlong_sphere(44, 3),
    }.items()
]


@pytest.mark.parametrize("mesh", CASES)
def test_pattern_is_that_of_three_edges(mesh):
    vertices, faces = mesh
    n = len(vertices)
    near = np.eye(n, dtype=int)
    near[tuple(meshes.edges_of(faces).T)] = 1
    near = near + near.T > 0
    pattern = SymmetricPattern(TriangleTopology(faces, n))
    matrix = pattern.matrix(np.arange(1.0, pattern.n_upper + 1))
    reach = np.linalg.matrix_power(near.astype(int), 3) > 0
    np.testing.assert_array_equal(matrix.toarray() != 0, reach)
    upper = matrix.toarray()[np.triu(reach)]  # row by row
    np.testing.assert_array_equal(upper, np.arange(1, pattern.n_upper + 1))
    np.testing.assert_array_equal(matrix.toarray(), matrix.toarray().T)


@pytest.mark.parametrize("largest_table", [0, 10**6], ids=["searched", "from a table"])
@pytest.mark.parametrize("mesh", CASES)
def test_places_of_all_pairs(mesh, largest_table, monkeypatch):
    monkeypatch.setattr(sparsity, "LARGEST_TABLE", largest_table)
    vertices, faces = mesh
    pattern = SymmetricPattern(TriangleTopology(faces, len(vertices)))
    numbers = pattern.matrix(np.arange(float(pattern.n_upper))).tocoo()
    low, high = 1, len(vertices)  # a window that not all vertices are in
    inside = (numbers.row >= low) & (numbers.col >= low)
    pairs = np.stack([numbers.row[inside], numbers.col[inside]]).astype(np.int32) - np.int32(low)
    found = np.empty((1, pairs.shape[1]), dtype=np.int32)
    ends = np.array([0]), np.array([1])
    pattern.places(low, high).numbers(pairs, ends, found)
    np.testing.assert_array_equal(found[0], numbers.data[inside])


def test_scattered_adds_up_repeated_places():
    places = np.array([3, 0, 3, 3], dtype=np.int32)
    total = scattered(places, np.array([1.0, 2.0, 4.0, 8.0]), 5)
    np.testing.assert_array_equal(total, [2, 0, 0, 13, 0])
