"""Preservation of volume: closed parts are moved along their normals after a step."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csgraph

from ..mesh.normals import dots, vertex_normals
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray

# Newton's method doubles the digits in each iteration; a part that needs more has collapsed.
MOST_ITERATIONS = 30

# An offset is found when the volume is right up to this part of the volumes that are summed up.
ROUNDING = 1e-13


class VolumeKeeper:
    """Keeps the volume that every closed part of a mesh had at the start.

    That is the volume within the triangles, which is exact and which other programs measure too.
    Each vertex moves along its normal by its local time of the step times one factor for its part.
    So the volume is a cubic polynomial of the factor, which Newton's method solves from 0.

    Diffusion moves the surface by about its local time times its mean curvature, so the volume is
    given back in the proportion in which it was taken.  The same offset everywhere would be many
    edges where a mesh is dense, and would fold thin parts there.

    Parameters
    ----------
    topology : TriangleTopology
    start : (n, 3)
        Positions whose volumes are kept.
    is_held : (n,) bool
        Vertices that do not move.

    Attributes
    ----------
    notes : tuple of str
        Parts that have no volume to keep, or have lost it.
    """

    def __init__(self, topology: TriangleTopology, start: FloatArray, is_held: BoolArray) -> None:
        self._topology = topology
        self._n_parts, self._part = csgraph.connected_components(
            topology.adjacency(), directed=False
        )
        self._part_of_triangle = self._part[topology.triangles[:, 0]]
        is_open = np.bincount(self._part[topology.on_boundary], minlength=self._n_parts) > 0
        self._is_moved = ~(is_held | is_open[self._part])
        # Products of coordinates lose digits far from the origin.
        count = np.bincount(self._part, minlength=self._n_parts)
        sums = [np.bincount(self._part, x, self._n_parts) for x in start.T]
        self._centre = (np.stack(sums, axis=1) / count[:, None])[self._part]
        self._volumes = self._polynomials(start, np.zeros_like(start))[0]
        n_open = int(np.count_nonzero(is_open))
        self.notes: tuple[str, ...] = ()
        if n_open:
            parts = "1 part is open and has" if n_open == 1 else f"{n_open} parts are open and have"
            self.notes = (f"{parts} no volume to keep: close the holes first if it is to stay",)

    def restored(self, positions: FloatArray, times: FloatArray) -> FloatArray:
        """Move closed parts so that they regain their volumes, (n, 3) to (n, 3).

        `times` (n,) are the local times of the step.  A part that has nearly vanished is not moved;
        `notes` says so.
        """
        # In units of the longest time the factor is a length.
        share = np.where(self._is_moved, times / (times.max(initial=0) or 1.0), 0.0)
        motion = share[:, None] * vertex_normals(self._topology, positions)
        value, slope, bend, twist = self._polynomials(positions, motion)
        sizes = self._sizes(positions)
        offset, is_right = np.zeros(self._n_parts), slope <= 0
        lost = np.zeros(self._n_parts, dtype=bool)
        for _ in range(MOST_ITERATIONS):
            missing = self._volumes - (value + offset * (slope + offset * (bend + offset * twist)))
            rate = slope + offset * (2 * bend + 3 * offset * twist)
            is_right |= np.abs(missing) <= ROUNDING * sizes
            # Beyond a turning point the polynomial has left the root next to 0.
            lost |= ~is_right & (rate <= 0)
            moves = ~(is_right | lost)
            if not moves.any():
                break
            offset[moves] += missing[moves] / rate[moves]
        lost |= ~is_right
        if lost.any():
            parts = "1 closed part has" if lost.sum() == 1 else f"{lost.sum()} closed parts have"
            note = f"{parts} collapsed and lost their volume; a smaller radius or tau avoids that"
            self.notes = (*(each for each in self.notes if "collapsed" not in each), note)
        offset[lost] = 0
        return positions + offset[self._part, None] * motion

    def notes_on_limit(self, restored: FloatArray, limited: FloatArray) -> tuple[str, ...]:
        """Note how many vertices of closed parts were held back by the limit after `restored`."""
        n_back = int(np.count_nonzero((restored != limited).any(axis=1) & self._is_moved))
        if not n_back:
            return ()
        vertices = "1 vertex" if n_back == 1 else f"{n_back} vertices"
        return (f"the volume is not kept exactly: the largest deviation held {vertices} back",)

    def _polynomials(self, positions: FloatArray, motion: FloatArray) -> FloatArray:
        """Coefficients of every part's volume by the offset, lowest first, (4, n_parts)."""
        corners = (positions - self._centre)[self._topology.triangles].swapaxes(0, 1)
        motions = motion[self._topology.triangles].swapaxes(0, 1)
        terms = np.zeros((4, self._topology.n_triangles))
        # The determinant of three sums of two, multiplied out.
        for first, a in enumerate((corners, motions)):
            for second, b in enumerate((corners, motions)):
                cross = np.cross(a[0], b[1])
                for third, c in enumerate((corners, motions)):
                    terms[first + second + third] += dots(cross, c[2]) / 6
        return np.stack([self._by_part(term) for term in terms])

    def _sizes(self, positions: FloatArray) -> FloatArray:
        """Sum of the volumes over all triangles, whatever their signs, (n_parts,)."""
        a, b, c = (positions - self._centre)[self._topology.triangles].swapaxes(0, 1)
        return self._by_part(np.abs(dots(np.cross(a, b), c)) / 6)

    def _by_part(self, of_triangles: FloatArray) -> FloatArray:
        sums = np.bincount(self._part_of_triangle, of_triangles, self._n_parts)
        return sums.astype(np.float64)
