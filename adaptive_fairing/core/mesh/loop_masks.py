"""Weights of Loop's subdivision rules at a vertex.

Source: C. Loop, Smooth subdivision surfaces based on triangles, 1987.
"""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import FloatArray, IntArray


def loop_alpha(valence: int | IntArray) -> FloatArray:
    """Total weight α(n) of the one-ring in Loop's vertex rule: x' = (1 - α) x + α/n Σ x_j.

    Source: C. Loop 1987; the paper's a(n) is α(n)/n.
    """
    n = np.asarray(valence, dtype=np.float64)
    return 5 / 8 - (3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2


def limit_weight(valence: int | IntArray) -> FloatArray:
    """Weight l of each neighbour in the limit position (1 - n l) x + l Σ x_j.

    Source: (3.6) of the paper, l = 1 / (n + 3 / (8 a(n))) with a(n) = α(n)/n.
    """
    return 1 / (valence + 3 * valence / (8 * loop_alpha(valence)))
