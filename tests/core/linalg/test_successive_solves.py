"""The start of a solve from the solutions of similar systems."""

import numpy as np
import pytest

from adaptive_fairing.core.linalg.successive_solves import SuccessiveSolves

N = 12


def definite_matrix():
    root = np.random.default_rng(0).normal(size=(N, N))
    return root @ root.T + np.eye(N)


def solved(matrix, *right_sides):
    solves = SuccessiveSolves()
    for right_side in right_sides:
        solves.add(np.linalg.solve(matrix, right_side), right_side)
    return solves


def test_without_a_solution_it_is_zero():
    np.testing.assert_array_equal(SuccessiveSolves().start(np.ones((N, 3))), np.zeros((N, 3)))


def test_a_right_side_in_the_span_of_the_last_two_is_solved():
    matrix = definite_matrix()
    first, second = np.random.default_rng(1).normal(size=(2, N, 3))
    wanted = 2 * first - 0.5 * second
    start = solved(matrix, np.ones((N, 3)), first, second).start(wanted)
    np.testing.assert_allclose(matrix @ start, wanted, rtol=1e-9, atol=1e-9)


def test_no_other_combination_of_the_last_two_is_nearer():
    matrix = definite_matrix()
    first, second, wanted = np.random.default_rng(2).normal(size=(3, N, 3))
    start = solved(matrix, first, second).start(wanted)
    residual = wanted - matrix @ start
    for right_side in (first, second):
        assert abs(np.sum(residual * np.linalg.solve(matrix, right_side))) < 1e-10


@pytest.mark.parametrize("copies", [1, 2])
@pytest.mark.parametrize("size", [0.0, 1.0])
def test_equal_solutions_and_zero_give_no_large_factors(copies, size):
    matrix = definite_matrix()
    right_side = size * np.ones((N, 3))
    start = solved(matrix, *[right_side] * copies).start(3 * right_side)
    np.testing.assert_allclose(matrix @ start, 3 * right_side, atol=1e-9)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_right_side_that_is_not_finite_gives_zero(bad):
    right_side = np.ones((N, 3))
    solves = solved(definite_matrix(), right_side)
    right_side[3, 1] = bad
    assert not solves.start(right_side).any()
