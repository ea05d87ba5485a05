"""Unit of length and direction of noise at each vertex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..mesh.density import mesh_density
from ..mesh.normals import vertex_normals
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import FloatArray


@dataclass(frozen=True)
class LocalFrame:
    """Unit of length and direction of noise at each vertex.

    Attributes
    ----------
    spacing : (n,)
        Mean distance to the neighbours h, 1 at loose vertices.
    normals : (n, 3)
        Unit vectors, area-weighted.
    mean : (n, n) csr_array
        Averages over the neighbours.
    """

    spacing: FloatArray
    normals: FloatArray
    mean: sparse.csr_array

    @classmethod
    def of(
        cls, topology: TriangleTopology, positions: FloatArray, smooth: FloatArray
    ) -> LocalFrame:
        """Measure the spacing of `positions` and the normals of `smooth`, (n, 3) both."""
        adjacency = topology.adjacency(np.float64)
        scale = sparse.diags_array(1 / np.maximum(topology.ring_size, 1))
        return cls(
            spacing_of(topology, positions, 0),
            vertex_normals(topology, smooth),
            sparse.csr_array(scale @ adjacency),
        )

    def along_normal(self, displacement: FloatArray) -> FloatArray:
        """Take the normal component of vectors (n, 3), in local edge lengths, (n,)."""
        component: FloatArray = np.einsum("nd,nd->n", displacement, self.normals) / self.spacing
        return component

    def rises(self, positions: FloatArray) -> FloatArray:
        """How far positions (n, 3) lie over the mean of their neighbours, as `along_normal`."""
        return self.along_normal(positions - self.mean @ positions)

    def raised(self, heights: FloatArray) -> FloatArray:
        """Turn heights (n,) along the normals, in local edge lengths, into vectors (n, 3)."""
        return (heights * self.spacing)[:, None] * self.normals

    def spread(self, values: FloatArray, passes: int) -> FloatArray:
        """Average values (n, …) half with those of the neighbours, several times."""
        for _ in range(passes):
            values = (values + self.mean @ values) / 2
        return values


def spacing_of(topology: TriangleTopology, positions: FloatArray, passes: int) -> FloatArray:
    """Local edge length, (n,), smoothed by (3.6); never 0."""
    spacing = mesh_density(topology, positions, "edge_length", passes)
    typical = float(np.median(spacing[~topology.is_loose]))
    spacing[topology.is_loose] = 1.0
    return np.maximum(spacing, 1e-9 * typical or 1.0)
