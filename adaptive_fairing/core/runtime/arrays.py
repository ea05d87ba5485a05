"""Types of arrays, for annotations."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]

SingleArray: TypeAlias = NDArray[np.float32]
"""As Blender keeps coordinates and weights."""

RealArray: TypeAlias = NDArray[np.floating[Any]]
"""In single or double precision."""

BoolArray: TypeAlias = NDArray[np.bool_]

IntArray: TypeAlias = NDArray[np.int32]
"""Numbers of vertices, triangles, half-edges and matrix entries as they are stored."""

IndexArray: TypeAlias = NDArray[np.intp]
"""Numbers as numpy's searches return them and its indexing takes them."""

LongArray: TypeAlias = NDArray[np.int64]
"""Numbers whose products must not overflow."""
