"""The fitted rule of irregular patches: positive, exact for constants, independent of the start."""

import itertools

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import LoopSpace, TriangleTopology
from adaptive_fairing.core.fem import table_cache
from adaptive_fairing.core.loop import basis
from adaptive_fairing.core.loop.basis import basis_table, evaluate_basis
from adaptive_fairing.core.loop.fitted_quadrature import (
    BARYCENTRIC,
    POINTS,
    fitted_weights,
    is_fitted,
)
from adaptive_fairing.core.loop.patch_class import Corner
from adaptive_fairing.core.loop.quadrature import quadrature_choice

VALENCES = [
    valences
    for valences in itertools.product(range(3, 13), repeat=3)
    if is_fitted(tuple(Corner(valence) for valence in valences)) and set(valences) != {6}
]


def test_weights_are_positive_and_integrate_constants():
    assert len(VALENCES) > 100
    for valences in VALENCES:
        weights = fitted_weights(valences)
        assert weights.min() > 0.01
        np.testing.assert_allclose(weights.sum(axis=1), 0.5, rtol=1e-14)
    assert POINTS.min() > 0.05
    assert POINTS.sum(axis=1).max() < 0.95


@pytest.mark.parametrize("order", [(1, 2, 0), (0, 2, 1)], ids=["rotated", "mirrored"])
def test_rule_goes_along_when_corners_change_places(order):
    moved = BARYCENTRIC[:, order]
    distance = np.linalg.norm(BARYCENTRIC[:, None] - moved[None], axis=2)
    assert distance.min(axis=1).max() < 1e-12
    for valences in VALENCES:
        turned = fitted_weights(tuple(valences[k] for k in order))
        np.testing.assert_allclose(
            fitted_weights(valences), turned[:, distance.argmin(axis=0)], rtol=1e-12
        )


def test_table_has_the_basis_at_the_fitted_points():
    choice = quadrature_choice(1e-3)
    for valences in [(5, 6, 7), (4, 7, 8), (6, 6, 10), (5, 5, 5)]:
        patch_class = tuple(Corner(valence) for valence in valences)
        table = basis_table(patch_class, choice)
        np.testing.assert_allclose(table.values, evaluate_basis(patch_class, POINTS), atol=1e-13)
        np.testing.assert_array_equal(table.weights, fitted_weights(valences))


def test_weights_by_valence_earn_their_place(monkeypatch):
    """Without them the error of a mesh of valences 3 to 10 is several times as large."""
    vertices, faces = meshes.random_closed(4, meshes.icosphere(3))
    topology = TriangleTopology(faces, len(vertices))
    exact = LoopSpace(topology, 1e-5).mass_matrix(vertices)

    def error():
        for cached in (basis._fitted_table, table_cache._kept_tables):
            cached.cache_clear()
        return abs(LoopSpace(topology).mass_matrix(vertices) - exact).max() / exact.max()

    with_valences = error()
    monkeypatch.setattr(basis, "fitted_weights", lambda valences: fitted_weights((6, 6, 6)))
    without = error()
    monkeypatch.undo()
    error()  # no table without them is left for other tests
    assert with_valences < 1e-3
    assert without > 2 * with_valences
