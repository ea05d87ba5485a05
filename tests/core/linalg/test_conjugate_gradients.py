"""Linear systems that cannot be solved: detected and reported with iteration and residual."""

import weakref
from itertools import pairwise

import numpy as np
import pytest
from scipy import sparse

from adaptive_fairing.core import SolverError
from adaptive_fairing.core.linalg.conjugate_gradients import conjugate_gradients
from adaptive_fairing.core.linalg.symmetric_matrix import SymmetricMatrix
from adaptive_fairing.core.linalg.symmetric_pattern import SymmetricPattern


def solve(matrix, right_side, start=None, held=(), tolerance=1e-10, max_iterations=100):
    n = len(matrix)
    right_side = np.asarray(right_side, dtype=float).reshape(n, -1)
    is_held = np.zeros(n, dtype=bool)
    is_held[list(held)] = True
    every_pair = sparse.csr_array(1 - np.eye(n, dtype=np.int8))
    upper = np.asarray(matrix, dtype=float)[np.triu_indices(n)]
    return conjugate_gradients(
        SymmetricMatrix.from_upper(SymmetricPattern(every_pair), upper),
        right_side,
        None if start is None else np.asarray(start, float).reshape(n, -1),
        is_held=is_held,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )


def test_an_indefinite_system_is_named_with_iteration_and_residual():
    message = r"^the linear system is not positive definite: pᵀAp = -\S+ in iteration 1, residual 1"
    with pytest.raises(SolverError, match=message):
        solve([[1, 2], [2, 1]], [1, -1])


def test_negative_diagonal_entries_are_counted():
    with pytest.raises(SolverError, match="not positive definite: 2 diagonal entries ≤ 0"):
        solve(np.diag([1.0, -1.0, 0.0]), [1, 1, 1])


def test_held_rows_may_be_anything():
    x, report = solve(np.diag([1.0, -1.0, 0.0]), [1, 1, 1], start=[0, 5, 6], held=[1, 2])
    assert x[0, 0] == pytest.approx(1, abs=1e-9)
    np.testing.assert_array_equal(x[1:, 0], [5, 6])
    assert report.converged


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("place", [(0, 0), (0, 1)])
def test_entries_that_are_no_numbers(value, place):
    matrix = np.array([[2.0, 1.0], [1.0, 2.0]])
    matrix[place] = matrix[place[::-1]] = value
    with pytest.raises(SolverError, match="not finite numbers"):
        solve(matrix, [1, 1])
    with pytest.raises(SolverError, match="not finite numbers"):
        solve(np.eye(2), [value, 1])


def test_without_a_start_it_is_0():
    matrix = np.diag(np.arange(1.0, 20)) + 0.5
    found = [solve(matrix, np.ones(19), start=start)[0] for start in (None, np.zeros(19))]
    np.testing.assert_array_equal(*found)


def test_a_right_side_that_nobody_else_needs_is_freed_for_the_solve():
    right_sides = [np.ones((4, 1))]
    known, is_kept = weakref.ref(right_sides[0]), []

    class Twice:
        """The matrix 2 I, which notes whether the right side is still there."""

        is_single = False

        def diagonal(self):
            return np.full(4, 2.0)

        def is_finite(self):
            return True

        def product(self, columns):
            is_kept.append(known() is not None)
            return 2 * columns

    x, _ = conjugate_gradients(
        Twice(),
        right_sides.pop(),
        is_held=np.zeros(4, dtype=bool),
        tolerance=1e-9,
        max_iterations=9,
    )
    np.testing.assert_allclose(x, 0.5)
    assert is_kept == [False]


def test_too_few_iterations_are_reported():
    matrix = np.diag(np.arange(1.0, 20)) + 0.5
    x, report = solve(matrix, np.ones(19), max_iterations=2, tolerance=1e-12)
    assert not report.converged
    assert report.iterations == 2
    residual = np.ones(19) - matrix @ x[:, 0]
    scale = 1 / np.diag(matrix)
    expected = np.sqrt(scale @ residual**2 / (scale @ np.ones(19)))
    assert report.residual == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("shift", [0.0, 1e-30, 1e-18, -1e-18])
def test_motions_that_rounding_hides_are_left_alone(shift):
    # The Laplacian of a ring: constants are in its kernel, up to a shift that rounding swallows.
    n = 12
    laplacian = 2 * np.eye(n) - np.roll(np.eye(n), 1, axis=0) - np.roll(np.eye(n), -1, axis=0)
    start = np.random.default_rng(0).normal(size=n) + 1e3
    x, report = solve(laplacian + shift * np.eye(n), np.zeros(n), start=start, tolerance=1e-300)
    assert report.converged
    np.testing.assert_allclose(x[:, 0], start.mean(), rtol=1e-9)


def test_a_solve_that_ends_early_depends_continuously_on_its_tolerance():
    """One iteration more or less is no leap: the last step goes as far as the residual has to."""
    generator = np.random.default_rng(5)
    factor = generator.normal(size=(12, 12))
    matrix, right_side = factor @ factor.T + np.eye(12), generator.normal(size=12)
    tolerances = np.geomspace(0.5, 1e-3, 2000)
    solves = [solve(matrix, right_side, tolerance=each) for each in tolerances]
    residuals = np.array([report.residual for _, report in solves])
    assert np.all(residuals <= tolerances * (1 + 1e-9))
    assert len({report.iterations for _, report in solves}) > 5
    exact = np.linalg.solve(matrix, right_side)
    leaps = [np.linalg.norm(b - a) for (a, _), (b, _) in pairwise(solves)]
    assert max(leaps) < 0.02 * np.linalg.norm(exact)
