"""Triangle surface, with the quantities that the automatic method measures on it."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..mesh.density import mesh_density, smoothed
from ..mesh.normals import dots, triangle_normals, unit_vectors, vertex_normals
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray
from ..runtime.lazy import cached_property
from .parameters import parameters


class TriangleSurface:
    """A surface of triangles; each quantity at its vertices is computed once.

    The local edge length h and the normals of a slightly smoothed surface are the unit of length
    and the direction in which noise is measured.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
        Positions, which must not be changed any more.
    """

    def __init__(self, topology: TriangleTopology, positions: FloatArray) -> None:
        self.topology, self.positions = topology, positions

    def with_frame(self, **measured: FloatArray | sparse.csr_array) -> TriangleSurface:
        """Return this surface with another `spacing`, other `normals`, or another `mean`."""
        other = TriangleSurface(self.topology, self.positions)
        own = {name: getattr(self, name) for name in ("spacing", "normals", "mean")}
        vars(other).update(own | measured)  # as if they had been computed already
        return other

    @cached_property
    def spacing(self) -> FloatArray:
        """Local edge length h, the mean distance to the neighbours, (n,); 1 at loose vertices.

        Never 0.
        """
        is_loose = self.topology.is_loose
        spacing = mesh_density(self.topology, self.positions, smoothing_passes=0)
        typical = float(np.median(spacing[~is_loose]))
        spacing[is_loose] = 1.0
        return np.maximum(spacing, 1e-9 * typical or 1.0)

    @cached_property
    def smooth_spacing(self) -> FloatArray:
        """Local edge length, smoothed by (3.6), (n,)."""
        return smoothed(self.topology, self.spacing, parameters().averaging_passes)

    @cached_property
    def normals(self) -> FloatArray:
        """Vertex normals, area-weighted, of length 1, (n, 3)."""
        return vertex_normals(self.topology, self.positions)

    @cached_property
    def mean(self) -> sparse.csr_array:
        """Matrix (n, n) that averages over the neighbours."""
        scale = sparse.diags_array(1 / np.maximum(self.topology.ring_size, 1))
        return sparse.csr_array(scale @ self.topology.adjacency(np.float64))

    def triangle_normals(self) -> FloatArray:
        """Compute the normals of the triangles, as long as twice their area, (m, 3)."""
        return triangle_normals(self.positions, self.topology.triangles)

    def along_normal(self, displacement: FloatArray) -> FloatArray:
        """Take the normal component of vectors (n, 3), in local edge lengths, (n,)."""
        component: FloatArray = dots(displacement, self.normals) / self.spacing
        return component

    def rises(self, positions: FloatArray) -> FloatArray:
        """Heights (n,) of positions (n, 3) over the mean of their neighbours, as `along_normal`."""
        return self.along_normal(positions - self.mean @ positions)

    def raised(self, heights: FloatArray) -> FloatArray:
        """Turn heights (n,) along the normals, in local edge lengths, into vectors (n, 3)."""
        return (heights * self.spacing)[:, None] * self.normals

    def spread(self, values: FloatArray, passes: int) -> FloatArray:
        """Average values (n, …) half with those of the neighbours, several times."""
        for _ in range(passes):
            values = (values + self.mean @ values) / 2
        return values

    @cached_property
    def crease_part(self) -> float:
        """Fraction of the inner edges that are creases, where triangles meet at an angle."""
        normal, twin = unit_vectors(self.triangle_normals()), self.topology.twin
        side = self.topology.inner_edges
        cosine = dots(normal[side // 3], normal[twin[side] // 3])
        return float(np.mean(cosine < np.cos(parameters().short_fit_angle))) if len(side) else 0.0


def mean_among(mean: sparse.csr_array, values: FloatArray, is_some: BoolArray) -> FloatArray:
    """Average values (n,) over those neighbours that are among some vertices, (n,) bool.

    Returns one value for each of the given rows (r, n) of `TriangleSurface.mean`, (r,); 0 where no
    neighbour is among them.
    """
    part = mean @ is_some.astype(float)
    average: FloatArray = mean @ np.where(is_some, values, 0) / np.where(part > 0, part, 1)
    return average
