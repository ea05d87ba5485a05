"""The pattern of the matrices, the places of pairs in it, and matrices with that pattern."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.linalg import symmetric_pattern
from adaptive_fairing.core.linalg.symmetric_matrix import SymmetricMatrix
from adaptive_fairing.core.linalg.symmetric_pattern import SymmetricPattern, scattered
from adaptive_fairing.core.runtime.threads import Workspace

CASES = [
    pytest.param(mesh, id=name)
    for name, mesh in {
        "tetrahedron": meshes.tetrahedron(),
        "valences 3 to 10": meshes.random_closed(1),
        "open": meshes.bumpy_disc(0),
        "pole of valence 44": meshes.latlong_sphere(44, 3),
        # 256 paths of two edges from one pole to the other: zero as a byte.
        "poles of valence 256": meshes.bipyramid(256),
    }.items()
]


def pattern_of(mesh):
    vertices, faces = mesh
    return SymmetricPattern(TriangleTopology(faces, len(vertices)).adjacency())


def numbered(pattern):
    """Matrix of the numbers of the entries, counted from 1."""
    return SymmetricMatrix.from_upper(pattern, np.arange(1.0, pattern.n_upper + 1))


@pytest.fixture(params=[7, 10**6], ids=["many chunks", "one chunk"])
def rows_per_chunk(request, monkeypatch):
    monkeypatch.setattr(symmetric_pattern, "MOST_ROWS", request.param)


@pytest.mark.usefixtures("rows_per_chunk")
@pytest.mark.parametrize("mesh", CASES)
def test_pattern_is_that_of_three_edges(mesh):
    vertices, faces = mesh
    n = len(vertices)
    near = np.eye(n, dtype=int)
    near[tuple(meshes.edges_of(faces).T)] = 1
    near = near + near.T > 0
    pattern = pattern_of(mesh)
    matrix = numbered(pattern).full()
    reach = np.linalg.matrix_power(near.astype(int), 3) > 0
    np.testing.assert_array_equal(matrix.toarray() != 0, reach)
    upper = matrix.toarray()[np.triu(reach)]  # row by row
    np.testing.assert_array_equal(upper, np.arange(1, pattern.n_upper + 1))
    np.testing.assert_array_equal(matrix.toarray(), matrix.toarray().T)
    assert matrix.has_canonical_format


@pytest.mark.usefixtures("rows_per_chunk")
@pytest.mark.parametrize("mesh", CASES)
def test_products_are_those_of_the_full_matrix(mesh):
    pattern = pattern_of(mesh)
    generator = np.random.default_rng(0)
    first, second = (
        SymmetricMatrix.from_upper(pattern, generator.normal(size=pattern.n_upper))
        for _ in range(2)
    )
    columns = generator.normal(size=(3, pattern.n))
    for matrix, full in (
        (first, first.full()),
        (first.plus(0.5, second), first.full() + 0.5 * second.full()),
    ):
        np.testing.assert_allclose(matrix.product(columns), (full @ columns.T).T, atol=1e-12)
        np.testing.assert_array_equal(matrix.diagonal(), full.diagonal())


@pytest.mark.parametrize("largest_table", [0, 10**6], ids=["searched", "from a table"])
@pytest.mark.parametrize("mesh", CASES)
def test_places_of_all_pairs_within_triangles(mesh, largest_table, monkeypatch):
    monkeypatch.setattr(symmetric_pattern, "LARGEST_TABLE", largest_table)
    vertices, faces = mesh
    pattern = pattern_of(mesh)
    low, high = 1, len(vertices)  # a window that not all vertices are in
    inside = faces[(faces >= low).all(axis=1)].T.astype(np.int32)
    a, b = np.triu_indices(3)
    found = np.empty((6, inside.shape[1]), dtype=np.int32)
    first = int(pattern.row_starts[2])
    pattern.places(low, high, Workspace()).numbers(inside - np.int32(low), (a, b), first, found)
    expected = numbered(pattern).full().toarray()[inside[a], inside[b]] - 1
    np.testing.assert_array_equal(found + first, expected)


@pytest.mark.parametrize("largest_table", [0, 10**6], ids=["searched", "from a table"])
@pytest.mark.parametrize("mesh", CASES)
def test_places_of_all_pairs_of_the_pattern(mesh, largest_table, monkeypatch):
    monkeypatch.setattr(symmetric_pattern, "LARGEST_TABLE", largest_table)
    pattern = pattern_of(mesh)
    numbers = numbered(pattern).full().tocoo()
    pairs = np.stack([numbers.row, numbers.col]).astype(np.int32)
    found = np.empty((3, pairs.shape[1]), dtype=np.int32)
    pattern.places(0, pattern.n, Workspace()).numbers(pairs, np.triu_indices(2), 0, found)
    np.testing.assert_array_equal(found[1] + 1, numbers.data)
    np.testing.assert_array_equal(found[[0, 2]], pattern.row_starts[pairs])


def test_scattered_adds_up_repeated_places():
    places = np.array([3, 0, 3, 3], dtype=np.int32)
    total = scattered(places, np.array([1.0, 2.0, 4.0, 8.0]), 5)
    np.testing.assert_array_equal(total, [2, 0, 0, 13, 0])
