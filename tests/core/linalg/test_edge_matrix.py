"""Matrices with an entry for every edge, against dense ones put together triangle by triangle."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.linalg.edge_matrix import EdgePattern

MESHES = {
    "closed": meshes.random_closed(2),
    "open": meshes.flat_grid(5, 4),
}


def dense(faces, n, entries):
    matrix = np.zeros((n, n))
    for triangle, own in zip(faces.tolist(), entries.T, strict=True):
        for k in range(3):
            i, j = triangle[k], triangle[(k + 1) % 3]
            matrix[i, j] += own[k]
            matrix[j, i] += own[k]
    return matrix


@pytest.fixture(params=MESHES)
def pair(request):
    vertices, faces = MESHES[request.param]
    n = len(vertices) + 2  # two loose ones
    entries = np.random.default_rng(0).normal(size=(3, len(faces)))
    return EdgePattern(TriangleTopology(faces, n)).summed(entries), dense(faces, n, entries)


def test_every_triangle_adds_its_entries_to_its_edges(pair):
    matrix, expected = pair
    np.testing.assert_allclose(matrix.full().toarray(), expected, atol=1e-14)


def test_sums_weights_and_products_are_those_of_the_dense_matrix(pair):
    matrix, expected = pair
    rng = np.random.default_rng(1)
    diagonal, weights = rng.uniform(1, 2, (2, len(expected)))
    np.testing.assert_allclose(matrix.row_sums(), expected.sum(axis=1), atol=1e-13)
    whole, expected = matrix.with_diagonal(diagonal), expected + np.diag(diagonal)
    together = whole.plus(0.5, whole.weighted(weights))
    root = np.diag(np.sqrt(weights))
    expected = expected + 0.5 * root @ expected @ root
    columns = rng.normal(size=(4, len(expected)))
    np.testing.assert_allclose(together.product(columns), columns @ expected, atol=1e-12)
    np.testing.assert_allclose(together.diagonal(), np.diag(expected))


def test_products_are_in_the_precision_of_the_matrix(pair):
    matrix, expected = pair
    single = matrix.in_precision(np.float32)
    columns = np.random.default_rng(1).normal(size=(3, len(expected)))
    product = single.product(columns)
    assert single.is_single and product.dtype == np.float32
    np.testing.assert_allclose(product, columns @ expected, atol=1e-4)
    assert not single.doubled().is_single
