"""Types of arrays, for annotations."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]

SingleArray: TypeAlias = NDArray[np.float32]
"""Single precision, in which Blender stores coordinates and weights."""

RealArray: TypeAlias = NDArray[np.floating[Any]]
"""Single or double precision."""

BoolArray: TypeAlias = NDArray[np.bool_]

IntArray: TypeAlias = NDArray[np.int32]
"""Indices of vertices, triangles, half-edges and matrix entries as they are stored."""

IndexArray: TypeAlias = NDArray[np.intp]
"""Indices as numpy's searches return them and its indexing takes them."""

LongArray: TypeAlias = NDArray[np.int64]
"""Integers whose products must not overflow."""
