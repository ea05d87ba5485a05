"""No triangle is turned over by fairing.

Smoothing also moves vertices along the surface: towards the middle of their neighbours, and inwards
at a rim.  Small triangles between larger ones, and those of a rim, may be turned over by that.
Their vertices keep their places along the surface then, and move along its normal alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .local_frame import LocalFrame
from .normals import triangle_normals, unit_vectors, vertex_normals
from .topology import TriangleTopology

FloatArray = NDArray[np.float64]

# A triangle counts as turned over if the cosine of the angle to the surface around it was more than
# the first of these before, and is less than the second one now.
UPRIGHT, TURNED = 0.2, 0.1

# Passes of averaging until noise and folds hardly disturb the normals.
NORMAL_PASSES = 5

# How often ways along the surface are cut in half until no triangle is turned over; to take one
# back may turn the next one over.
MOST_ROUNDS = 32


class Unfolding:
    """What takes back the moves along the surface that turn triangles over.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
        Before fairing.
    frame : LocalFrame
    """

    def __init__(
        self, topology: TriangleTopology, positions: FloatArray, frame: LocalFrame
    ) -> None:
        self._positions, self._triangles = positions, topology.triangles
        normals = vertex_normals(topology, positions)
        for _ in range(NORMAL_PASSES):
            normals = unit_vectors(frame.spread(normals, 1))
        self._normals = normals
        self._upwards = unit_vectors(normals[topology.triangles].sum(axis=1))
        self._was_upright = self._cosines(positions, slice(None)) > UPRIGHT

    def unfolded(self, faired: FloatArray) -> FloatArray:
        """Return faired positions (n, 3) in which no triangle is turned over, as far as possible.

        Only vertices of such triangles differ from `faired`.
        """
        move = faired - self._positions
        along = move - np.einsum("nd,nd->n", move, self._normals)[:, None] * self._normals
        result, taken_back = faired, np.zeros(len(faired))
        judged = np.flatnonzero(self._was_upright)
        for _ in range(MOST_ROUNDS):
            turned = judged[self._cosines(result, judged) < TURNED]
            if not len(turned):
                break
            vertices = np.unique(self._triangles[turned])
            taken_back[vertices] += (1 - taken_back[vertices]) / 2
            result = faired - taken_back[:, None] * along
            # Elsewhere nothing has changed.
            judged = np.flatnonzero(
                self._was_upright & (taken_back[self._triangles] > 0).any(axis=1)
            )
        return result

    def _cosines(self, positions: FloatArray, faces: NDArray[np.intp] | slice) -> FloatArray:
        """Cosines of the angles of triangles to the surface around them."""
        normal = unit_vectors(triangle_normals(positions, self._triangles[faces]))
        cosines: FloatArray = np.einsum("fd,fd->f", normal, self._upwards[faces])
        return cosines
