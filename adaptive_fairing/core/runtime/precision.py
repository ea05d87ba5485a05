"""Floating-point precision of the finite elements.

A step of a large mesh is computed in single precision, where that changes nothing that counts:
positions stay in double precision, and rounding makes an error of 1e-6 in what the step adds to
them, far below that of the quadrature.  The bounds here say where it does not serve.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Precision: TypeAlias = type[np.floating[Any]]

RealArray: TypeAlias = NDArray[np.floating[Any]]
"""An array in either precision."""

SINGLE_TRIANGLES = 20_000
"""Triangles from which on a step takes long enough for its time to count."""

SINGLE_TOLERANCE = 1e-4
"""Least quadrature tolerance: a hundred times the rounding of matrix entries."""

SINGLE_TIMES = 1e-15, 1e3
"""Bounds for the largest timestep or diffusivity in the [-3, 3]^3 frame: no number overflows."""

THINNEST_IN_SINGLE = 1e-3
"""Least ratio of area element and squared tangents: rounding makes thinner metrics indefinite."""

SMALLEST_IN_SINGLE = 1e-4
"""Least length of tangents over the size of a chunk, whose positions are rounded to 1e-7 of it."""

SHORTEST_IN_SINGLE = 1e-6
"""Least length of tangents in the [-3, 3]^3 frame: no sixth power of it underflows."""

LEAST_MASS_IN_SINGLE = 1e-3
"""Least row sum of M over the diagonal of M + L: rounding gives rows of L, whose sum is 0, 1e-7."""


class SinglePrecisionError(ArithmeticError):
    """Single precision is too coarse for a surface: double precision is needed."""
