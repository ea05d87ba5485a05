"""Bounds on the motion of vertices, applied last, whatever was estimated."""

from __future__ import annotations

import numpy as np

from ..problem.deviation import limited
from ..runtime.arrays import FloatArray
from .noise.level import beyond_clean
from .parameters import parameters
from .triangle_surface import TriangleSurface


class Bounds:
    """Largest displacement of every vertex: no further than noise has moved it.

    Parameters
    ----------
    before : TriangleSurface
        Surface before denoising.
    frame : TriangleSurface
        The same surface, slightly smoothed: unit of length of the noise.
    start : (n, 3)
        Positions with spikes put back; a vertex may move further by the same distance.
    reach : (n,)
        Standard deviation of the noise in local edge lengths; 0 where none was judged.
    """

    def __init__(
        self,
        before: TriangleSurface,
        frame: TriangleSurface,
        start: FloatArray,
        reach: FloatArray,
    ) -> None:
        self._before, self._frame, self._reach = before.positions, frame, reach
        self._spike = np.linalg.norm(start - before.positions, axis=1)
        # The largest of n deviates lies at about √(2 ln n) of them.
        n_judged = max(int(np.count_nonzero(reach)), 2)
        self._deviations = parameters().extra_deviations + float(np.sqrt(2 * np.log(n_judged)))

    def kept(self, positions: FloatArray, strength: float) -> FloatArray:
        """Shorten displacements to positions (n, 3) that exceed the bound for `strength`."""
        frame, noise = self._frame, beyond_clean(strength * self._reach)
        # Boundaries and cuts, where nothing is judged, may go as far as their neighbours.
        judged = (self._reach > 0).astype(float)
        part = frame.mean @ judged
        beside = (frame.mean @ (judged * noise)) / np.where(part > 0, part, 1)
        noise = np.where(self._reach > 0, noise, beside)
        most = self._deviations * noise * frame.spacing + self._spike
        return limited(positions, self._before, most)
