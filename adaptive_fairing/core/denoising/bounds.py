"""What holds for the motion of vertices after the mixture, whatever was estimated.

Filters also move vertices along the surface: towards the mean of their neighbours, and inwards at a
boundary.  A large part of that is not noise, and small triangles between larger ones may be turned
over.  So vertices make only a fraction of their move along the surface, at most one standard
deviation of the noise, and less where a triangle would be turned over.  They make their whole move
along the normal.

In a mesh of a scanner or a depth camera, noise moved the vertices along the rays, not along the
surface.  So in the end they move along their rays onto the denoised surface.

Where the noise is as large as the edges, the noisy triangles do not show where the surface is and
which of its sides is up.  There vertices follow the filters.

Then folds that noise has left are smoothed.  A triangle is folded if it faces against the sum of
those across its edges, weighted by area.  Where a spike was put back, or noise wider than the
triangles was removed, the vertices of a fold move half-way to the mean of their neighbours, in a
few rounds.  Other folds belong to the mesh, from bad cuts or decimation: they stay.

Last, no vertex goes further than noise has moved it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..mesh.normals import dots, triangle_normals, unit_vectors, vertex_normals
from ..mesh.topology import TriangleTopology
from ..problem.deviation import limited
from ..runtime.arrays import BoolArray, FloatArray
from .boundary_curves import BoundaryCurves
from .noise.line_of_sight import lines_of_sight, on_rays
from .noise_model import NoiseCorrelation
from .parameters import parameters
from .triangle_surface import TriangleSurface, mean_among


class Sliding:
    """Limits for the moves of vertices along the surface.

    Parameters
    ----------
    start : TriangleSurface
        Surface before denoising.
    frame : TriangleSurface
        The same surface, slightly smoothed.
    noise : (n,)
        Standard deviation in local edge lengths.
    correlation : NoiseCorrelation, optional
        Of the noise, where boundaries are denoised as curves; None where they stay.
    """

    def __init__(
        self,
        start: TriangleSurface,
        frame: TriangleSurface,
        noise: FloatArray,
        correlation: NoiseCorrelation | None = None,
    ) -> None:
        tuned = parameters()
        self._topology, self._triangles = start.topology, start.topology.triangles
        self._positions = start.positions
        self._rays = lines_of_sight(start.topology, start.positions)
        self._curves = None
        if correlation is not None and start.topology.on_boundary.any():
            self._curves = BoundaryCurves(start, noise, correlation)
        normals = start.normals
        for _ in range(tuned.averaging_passes):
            normals = unit_vectors(frame.spread(normals, 1))
        first, second, third = self._triangles.T
        self._upwards = unit_vectors(normals[first] + normals[second] + normals[third])
        was_upright = dots(start.triangle_normals(), self._upwards) > 0
        self._reach = noise * start.spacing
        # More noise than an edge leaves nothing to see in the triangles.
        self._is_free = noise > 1
        is_told = ~self._is_free[self._triangles].any(axis=1)
        self._may_turn = is_told & was_upright

    def limited(self, faired: FloatArray, strength: float | None = None) -> FloatArray:
        """Return denoised positions (n, 3) with less sliding, if possible without turned triangles.

        Boundaries are denoised by the noise times `strength`; without one they are as filtered.
        """
        tuned = parameters()
        move = faired - self._positions
        # Those of the denoised surface: a vertex near a crease must not leave its flat face.
        normals = vertex_normals(self._topology, faired)
        along = move - dots(move, normals)[:, None] * normals
        length = np.linalg.norm(along, axis=1)
        too_far = 1 - np.minimum(1, self._reach / np.where(length > 0, length, 1))
        beyond = along * too_far[:, None]
        move, along = move - beyond, along - beyond
        along_kept, kept = np.full(len(faired), tuned.sliding_fraction), np.ones(len(faired))
        if self._curves is not None and strength is not None:
            boundary = self._curves.vertices
            way = self._curves.moves(move, normals, strength)
            along[boundary] = way - dots(way, normals[boundary])[:, None] * normals[boundary]
            move[boundary], along_kept[boundary] = way, 1
        judged = np.flatnonzero(self._may_turn)
        for done in range(2 * tuned.rounds):
            slower = move - (1 - along_kept)[:, None] * along
            result = self._positions + kept[:, None] * slower
            turned = judged[self._is_turned(result, judged)]
            if not len(turned):
                break
            vertices = np.unique(self._triangles[turned])
            along_kept[vertices] /= 2
            if done >= tuned.rounds:
                kept[vertices] /= 2
            # Elsewhere nothing has changed.
            is_near = (along_kept[self._triangles] < tuned.sliding_fraction).any(axis=1)
            judged = np.flatnonzero(self._may_turn & is_near)
        result = np.where(self._is_free[:, None], faired, result)
        if self._rays is None:
            return result
        return on_rays(TriangleSurface(self._topology, result), self._positions, self._rays)

    def _is_turned(self, positions: FloatArray, faces: NDArray[np.intp]) -> BoolArray:
        """Whether each of some triangles, which were upright, is turned over."""
        normals = triangle_normals(positions, self._triangles[faces])
        turned: BoolArray = dots(normals, self._upwards[faces]) < 0
        return turned


def unfolded(
    positions: FloatArray, before: TriangleSurface, is_at: BoolArray, may_move: BoolArray
) -> FloatArray:
    """Smooth the folds of positions (n, 3) at some vertices.

    Parameters
    ----------
    positions : (n, 3)
    before : TriangleSurface
        Surface before denoising.
    is_at, may_move : (n,) bool
        Vertices at which folds are smoothed, and vertices that may move.
    """
    topology, result = before.topology, positions.copy()
    triangles = topology.triangles
    of_noise = is_at[triangles].any(axis=1)
    for _ in range(parameters().rounds if of_noise.any() else 0):
        vertices = np.unique(triangles[of_noise & are_folded(topology, result)])
        vertices = vertices[may_move[vertices]]
        if not len(vertices):
            break
        result[vertices] = (result[vertices] + before.mean[vertices] @ result) / 2
    return result


def are_folded(topology: TriangleTopology, positions: FloatArray) -> BoolArray:
    """Whether each triangle faces against the sum of those across its edges, (m,)."""
    normals = triangle_normals(positions, topology.triangles)
    # Without a triangle across, twin is -1: the last row, which is zero.
    beyond = np.append(normals, np.zeros((1, 3)), axis=0)
    across = (topology.twin // 3).reshape(-1, 3)
    around = beyond[across[:, 0]] + beyond[across[:, 1]] + beyond[across[:, 2]]
    folded: BoolArray = dots(normals, around) < 0
    return folded


class Bounds:
    """Largest displacement of every vertex: no further than noise has moved it.

    Parameters
    ----------
    before : TriangleSurface
        Surface before denoising.
    frame : TriangleSurface
        The same surface, slightly smoothed: unit of length of the noise.
    is_judged : (n,) bool
        Where the noise was judged; others may go as far as their neighbours.
    start : (n, 3)
        Positions with spikes put back; a vertex may move further by the same distance.
    reach : (n,)
        Standard deviation of the noise in local edge lengths.
    """

    def __init__(
        self,
        before: TriangleSurface,
        frame: TriangleSurface,
        is_judged: BoolArray,
        start: FloatArray,
        reach: FloatArray,
    ) -> None:
        self._before = before.positions
        beside = mean_among(frame.mean, reach, is_judged)
        self._noise = np.where(is_judged, reach, beside) * frame.spacing
        self._spike = np.linalg.norm(start - before.positions, axis=1)
        # The largest of n deviates lies at about √(2 ln n) of them.
        n_judged = max(int(np.count_nonzero(reach)), 2)
        self._deviations = parameters().extra_deviations + float(np.sqrt(2 * np.log(n_judged)))

    def kept(self, positions: FloatArray, strength: float) -> FloatArray:
        """Shorten displacements to positions (n, 3) that exceed the bound for `strength`."""
        most = self._deviations * strength * self._noise + self._spike
        return limited(positions, self._before, most)
