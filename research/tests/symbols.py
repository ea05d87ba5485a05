"""Exact Fourier symbols of Loop and linear elements on the grid of equilateral triangles.

They are what `research.claims.bandwidth` measures of assembled matrices.
"""

from __future__ import annotations

import itertools

import numpy as np

DIRECTIONS = np.array([[1.0, 0.0], [0.5, 0.75**0.5], [-0.5, 0.75**0.5]])
"""The three directions of the edges, of length 1."""

CELL_AREA = 0.75**0.5
"""Area of the grid per vertex."""

ALIASES = 8
"""Aliases in each direction that are summed; the terms fall at least with the 6th power."""


def loop_symbols(waves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return m(k) and l(k) of the Loop basis from the Fourier transform of its basis function.

    On the regular grid that is the quartic box spline N222. By Poisson's summation formula
    m(k) = Σ |φ̂(k + g)|² / A and l(k) = Σ |k + g|² |φ̂(k + g)|² / A over the reciprocal lattice g,
    with φ̂(k) = A Π sinc²(k·e/2) over the edge directions e and A the area per vertex.

    Parameters
    ----------
    waves
        (n, 2) wave vectors, for edges of length 1.
    """
    reciprocal = 2 * np.pi * np.linalg.inv(DIRECTIONS[:2]).T
    mass, stiffness = np.zeros(len(waves)), np.zeros(len(waves))
    for i, j in itertools.product(range(-ALIASES, ALIASES + 1), repeat=2):
        k = waves + i * reciprocal[0] + j * reciprocal[1]
        squared = CELL_AREA * np.prod(np.sinc(k @ DIRECTIONS.T / (2 * np.pi)) ** 4, axis=1)
        mass += squared
        stiffness += np.sum(k * k, axis=1) * squared
    return mass, stiffness


def linear_symbols(waves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return m(k) and l(k) of linear elements: the six neighbours have A / 12 and -1 / √3."""
    cosines = np.cos(waves @ DIRECTIONS.T).sum(axis=1)
    mass = CELL_AREA * (0.5 + cosines / 6)
    stiffness = 2 / 3**0.5 * (3 - cosines)
    return mass, stiffness
