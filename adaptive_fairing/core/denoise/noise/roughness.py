"""The roughness of a mesh at each vertex, as white noise would make it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse

from ...mesh.normals import dots
from ...runtime.arrays import FloatArray
from ..triangle_surface import TriangleSurface


class Roughness(NamedTuple):
    """What two differences with the mean of the neighbours leave: noise for the most part.

    Attributes
    ----------
    value : (n,)
        Magnitude along the normals, over the deviation that white noise of one local edge length
        along the normals has there.
    fineness : (n,)
        Variance that noise of one unit of length everywhere has in `value`. About 1 / h², in
        1 / length².
    """

    value: FloatArray
    fineness: FloatArray

    @classmethod
    def of(cls, positions: FloatArray, frame: TriangleSurface) -> Roughness:
        """Measure positions (n, 3)."""
        difference = sparse.identity(len(positions), format="csr") - frame.mean
        twice = sparse.csr_array(difference @ difference)
        magnitude = np.abs(frame.along_normal(twice @ positions))
        entries = sparse.coo_array(twice)
        row, column = entries.coords
        cosine = dots(frame.normals[row], frame.normals[column])
        per_length = np.square(entries.data * cosine / frame.spacing[row])
        per_edge = per_length * np.square(frame.spacing[column])
        n = len(positions)
        edge_variance = np.maximum(np.bincount(row, per_edge, n), 1e-12)
        fineness = np.bincount(row, per_length, n) / edge_variance
        return cls(magnitude / np.sqrt(edge_variance), np.maximum(fineness, 1e-12))
