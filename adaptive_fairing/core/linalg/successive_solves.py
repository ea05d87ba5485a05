"""Starting vectors for a series of similar linear systems.

Source: Fischer, "Projection techniques for iterative solution of Ax = b with successive right-hand
sides", Computer Methods in Applied Mechanics and Engineering 163, 1998.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from ..runtime.arrays import FloatArray

# With a third solution the start gets no better: the matrices have changed too much since.
SOLUTIONS_KEPT = 2

# Solutions that differ by less than the square root of this part count as one.
LEAST_PIVOT = 1e-10


class SuccessiveSolves:
    """The last solutions of a series of systems A x = b whose matrices change little by little.

    The best start of the next solve, in the norm of its A, is the projection of its solution onto
    the span of the last ones.  The products with A that this needs are those of the last matrices
    instead: A times a solution was its right side.  So it costs no product with a matrix.
    """

    def __init__(self) -> None:
        self._solutions: deque[FloatArray] = deque(maxlen=SOLUTIONS_KEPT)
        self._right_sides: deque[FloatArray] = deque(maxlen=SOLUTIONS_KEPT)

    def add(self, solution: FloatArray, right_side: FloatArray) -> None:
        """Note the solution of a system and its right side, (n, k) each; neither is copied."""
        self._solutions.append(solution)
        self._right_sides.append(right_side)

    def start(self, right_side: FloatArray) -> FloatArray:
        """Combine the last solutions for a right side (n, k).

        The columns are one system, as in `conjugate_gradients`.  Without a solution, and for a
        right side that is not finite, the start is 0.
        """
        start = np.zeros_like(right_side)
        projected = np.array([_product(x, right_side) for x in self._solutions])
        if not len(projected) or not np.isfinite(projected).all():
            return start
        energies = np.array([[_product(x, b) for b in self._right_sides] for x in self._solutions])
        # Symmetric but for the change of the matrices.
        energies = (energies + energies.T) / 2
        factors = np.linalg.lstsq(energies, projected, rcond=LEAST_PIVOT)[0]
        for factor, solution in zip(factors.tolist(), self._solutions, strict=True):
            start += factor * solution
        return start


def _product(first: FloatArray, second: FloatArray) -> float:
    return float(np.einsum("nk,nk->", first, second))
