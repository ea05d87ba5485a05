"""Quadrature rules: exact to their degree, symmetric, with positive weights inside."""

from math import factorial

import numpy as np
import pytest

from adaptive_fairing.core import FairingError
from adaptive_fairing.core.loop.quadrature import quadrature_choice, triangle_rule

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def rules_in_use():
    choices = [quadrature_choice(tolerance) for tolerance in TOLERANCES]
    degrees = {c.regular.degree for c in choices} | {c.irregular.degree for c in choices}
    return sorted(degrees)


@pytest.mark.parametrize("degree", [*range(1, 15), 20])
def test_rule_integrates_all_polynomials_of_its_degree(degree):
    rule = triangle_rule(degree)
    assert rule.degree >= degree
    x, y = rule.points.T
    for a in range(rule.degree + 1):
        for b in range(rule.degree + 1 - a):
            exact = factorial(a) * factorial(b) / factorial(a + b + 2)
            assert np.sum(rule.weights * x**a * y**b) == pytest.approx(exact, rel=1e-12), (a, b)


@pytest.mark.parametrize("degree", rules_in_use())
def test_points_lie_inside_and_weights_are_positive(degree):
    rule = triangle_rule(degree)
    assert (rule.weights > 0).all()
    assert rule.points.min() > 0
    assert rule.points.sum(axis=1).max() < 1


@pytest.mark.parametrize("degree", rules_in_use())
def test_rule_does_not_depend_on_the_corner_at_which_a_face_starts(degree):
    rule = triangle_rule(degree)
    barycentric = np.column_stack([1 - rule.points.sum(axis=1), rule.points])
    for order in ([1, 2, 0], [0, 2, 1]):  # these two generate all six symmetries
        moved = barycentric[:, order]
        distance = np.linalg.norm(barycentric[:, None] - moved[None], axis=2)
        assert distance.min(axis=1).max() < 1e-13
        np.testing.assert_allclose(rule.weights[distance.argmin(axis=1)], rule.weights, rtol=1e-13)


def test_tighter_tolerance_never_gets_a_coarser_choice():
    choices = [quadrature_choice(tolerance) for tolerance in TOLERANCES]
    for measure in (
        [c.regular.degree for c in choices],
        [c.irregular.degree for c in choices],
        [c.depth for c in choices],
    ):
        assert measure == sorted(measure)


@pytest.mark.parametrize("tolerance", [0, -1, 1e-9, 2, float("nan")])
def test_tolerance_out_of_range_is_refused_by_name(tolerance):
    with pytest.raises(FairingError, match="quadrature_tolerance"):
        quadrature_choice(tolerance)
