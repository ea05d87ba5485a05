"""Weights of Loop's limit positions."""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import FloatArray
from .loop_masks import limit_weight
from .topology import TriangleTopology


def limit_weights(topology: TriangleTopology) -> FloatArray:
    """Weights (n_vertices,) of each neighbour in limit positions inside; 0 for other vertices."""
    # One cosine per valence, not per vertex.
    valences = np.arange(1, topology.ring_size.max(initial=0) + 1)
    weights: FloatArray = np.append(0.0, limit_weight(valences))[topology.ring_size]
    weights[topology.on_boundary] = 0
    return weights
