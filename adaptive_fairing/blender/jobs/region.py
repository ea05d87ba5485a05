"""Part of a mesh around a region, so that a small region of a large mesh is denoised quickly.

The noise is estimated there alone, not where earlier runs have removed it. numpy only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

RINGS = 4
"""Rings of neighbours around a region that are solved with it and stay where they are."""


@dataclass(frozen=True)
class RegionMesh:
    """A part of a mesh.

    Attributes
    ----------
    vertex_of
        (k,) vertices of the whole mesh.
    triangles
        (m, 3) indices into `vertex_of`.
    """

    vertex_of: NDArray[np.intp]
    triangles: NDArray[np.int32]


def region_mesh(triangles: NDArray[np.int32], weights: NDArray[np.float64]) -> RegionMesh:
    """Cut out the vertices with a weight and `RINGS` rings around them.

    Parameters
    ----------
    triangles
        (m, 3) of the whole mesh.
    weights
        (n,) in [0, 1], some of them above 0.
    """
    is_inside = weights > 0
    for _ in range(RINGS):
        is_near = is_inside[triangles].any(axis=1)
        is_inside[triangles[is_near]] = True
    vertex_of = np.flatnonzero(is_inside)
    number = np.full(len(weights), -1, dtype=np.int32)
    number[vertex_of] = np.arange(len(vertex_of), dtype=np.int32)
    whole = is_inside[triangles].all(axis=1)
    return RegionMesh(vertex_of, number[triangles[whole]])
