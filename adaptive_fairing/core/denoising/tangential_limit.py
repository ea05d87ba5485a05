"""Limit of the motion of vertices along the surface.

Filters also move vertices along the surface: towards the mean of their neighbours, and inwards at a
boundary.  A large part of that is not noise, and small triangles between larger ones may be turned
over.  So vertices make only a fraction of their move along the surface, at most one standard
deviation of the noise, and less where a triangle would be turned over.  They make their whole move
along the normal.

In a mesh of a scanner or a depth camera, noise moved the vertices along the rays, not along the
surface.  So in the end they move along their rays onto the denoised surface.

Where the noise is as large as the edges, the noisy triangles do not show where the surface is and
which of its sides is up.  There vertices follow the filters.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..mesh.normals import dots, triangle_normals, unit_vectors, vertex_normals
from ..runtime.arrays import BoolArray, FloatArray
from .boundary_curves import BoundaryCurves
from .noise.line_of_sight import lines_of_sight, on_rays
from .parameters import parameters
from .triangle_surface import TriangleSurface


class Sliding:
    """Limits for the moves of vertices along the surface.

    Parameters
    ----------
    start : TriangleSurface
        Surface before denoising.
    frame : TriangleSurface
        The same surface, slightly smoothed.
    has_creases : bool
        Whether the denoised surface has creases.  If so, its normals define the directions along
        the surface, because a vertex on a flat face near a crease must not leave the face.
        Otherwise the smoothed normals of the noisy surface do, which slivers and boundaries do not
        disturb.
    noise : (n,)
        Standard deviation in local edge lengths.
    boundary_moves : bool
        Whether boundaries are denoised as curves.
    """

    def __init__(
        self,
        start: TriangleSurface,
        frame: TriangleSurface,
        has_creases: bool,
        noise: FloatArray,
        boundary_moves: bool = False,
    ) -> None:
        tuned = parameters()
        self._topology, self._triangles = start.topology, start.topology.triangles
        self._positions, self._has_creases = start.positions, has_creases
        normals = start.normals
        for _ in range(tuned.normal_passes):
            normals = unit_vectors(frame.spread(normals, 1))
        self._normals = normals
        self._rays = lines_of_sight(start.topology, start.positions)
        moves = boundary_moves and start.topology.on_boundary.any()
        self._curves = BoundaryCurves(start, noise) if moves else None
        self._upwards = unit_vectors(normals[self._triangles].sum(axis=1))
        self._before = unit_vectors(start.triangle_normals())
        cosines = dots(self._before, self._upwards)
        self._was_upright = cosines > tuned.upright_cosine
        self._reach = noise * start.spacing
        self._is_free = noise > tuned.most_edges
        is_told = ~self._is_free[self._triangles].any(axis=1)
        self._may_turn = is_told & (cosines > -tuned.upright_cosine)

    def limited(self, faired: FloatArray, strength: float = 1.0) -> FloatArray:
        """Return denoised positions (n, 3) with less sliding, if possible without turned triangles.

        Boundaries are denoised by the noise times `strength`.
        """
        tuned = parameters()
        move = faired - self._positions
        normals = vertex_normals(self._topology, faired) if self._has_creases else self._normals
        along = move - dots(move, normals)[:, None] * normals
        length = np.linalg.norm(along, axis=1)
        too_far = 1 - np.minimum(1, self._reach / np.where(length > 0, length, 1))
        beyond = along * too_far[:, None]
        move, along = move - beyond, along - beyond
        along_kept, kept = np.full(len(faired), tuned.sliding_fraction), np.ones(len(faired))
        if self._curves is not None:
            boundary = self._curves.vertices
            way = self._curves.moves(move[boundary], normals[boundary], strength)
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
        """Whether each of some triangles is turned over."""
        normal = unit_vectors(triangle_normals(positions, self._triangles[faces]))
        is_down = dots(normal, self._upwards[faces]) < parameters().upright_cosine
        is_against = dots(normal, self._before[faces]) < 0
        turned: BoolArray = is_down & (self._was_upright[faces] | is_against)
        return turned
