"""Probes that measure how much of its noise a filter removes: small noise of our own.

The signs are as good as random, but follow from the mesh: a mesh that is turned, mirrored,
renumbered or moved by rounding has the same ones, and the same result.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csgraph

from ..mesh.topology import TriangleTopology
from ..runtime.arrays import FloatArray
from .local_frame import LocalFrame, spacing_of

# The sign is that of a wave in the distance to the middle of the mesh, so many radians per typical
# edge: noise moves every vertex by many waves, rounding by less than a millionth of one.  (Edge
# lengths would not do: on contoured volumes many are alike.)
WAVES = 1e3


def probe_signs(topology: TriangleTopology, positions: FloatArray, frame: LocalFrame) -> FloatArray:
    """Signs ±1 of the vertices, (n,), for displacements along the normals.

    They change, all of a connected part, if the normals do: the displacements stay.
    """
    is_used = ~topology.is_loose
    distance = np.linalg.norm(positions - positions[is_used].mean(axis=0), axis=1)
    typical = float(np.median(spacing_of(topology, positions, 0)[is_used]))
    signs = np.where(np.sin(WAVES / typical * distance) < 0, -1.0, 1.0)
    # Bumps point along the normals or against them.
    bumps = frame.along_normal(positions - frame.mean @ positions)
    _, part = csgraph.connected_components(topology.adjacency(), directed=False)
    flipped: FloatArray = signs * np.where(np.bincount(part, signs * bumps) < 0, -1.0, 1.0)[part]
    return flipped
