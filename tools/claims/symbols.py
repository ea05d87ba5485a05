"""Fourier symbols of mass and stiffness matrices on the regular triangular grid.

On the grid of equilateral triangles every row of a matrix is the same stencil. On the wave
exp(i k·x) it acts as a number, its symbol: m(k) for M, l(k) for L. One semi-implicit step with a
uniform T damps the wave by m / (m + T l).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from samples.triangles import FloatArray


def wave_vector(wavelength: FloatArray, angle: float) -> FloatArray:
    """Return k (n, 2) of waves of given lengths that run at an angle to an edge direction."""
    size = 2 * np.pi / np.asarray(wavelength, dtype=float)
    return size[:, None] * np.array([np.cos(angle), np.sin(angle)])


def measured_symbol(
    matrix: sparse.csr_array, positions: FloatArray, centre: int, waves: FloatArray
) -> FloatArray:
    """Return the symbol of a matrix from the row of one vertex that is far from the boundary."""
    row = matrix[[centre], :].tocoo()
    offset = positions[row.col, :2] - positions[centre, :2]
    return np.cos(waves @ offset.T) @ row.data
