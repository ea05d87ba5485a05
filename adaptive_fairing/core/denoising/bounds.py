"""Bounds on the motion of vertices, applied last, whatever was estimated."""

from __future__ import annotations

import numpy as np

from ..problem.deviation import limited
from ..runtime.arrays import BoolArray, FloatArray
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
        judged = is_judged.astype(float)
        part = frame.mean @ judged
        beside = (frame.mean @ (judged * reach)) / np.where(part > 0, part, 1)
        self._noise = np.where(is_judged, reach, beside) * frame.spacing
        self._spike = np.linalg.norm(start - before.positions, axis=1)
        # The largest of n deviates lies at about √(2 ln n) of them.
        n_judged = max(int(np.count_nonzero(reach)), 2)
        self._deviations = parameters().extra_deviations + float(np.sqrt(2 * np.log(n_judged)))

    def kept(self, positions: FloatArray, strength: float) -> FloatArray:
        """Shorten displacements to positions (n, 3) that exceed the bound for `strength`."""
        most = self._deviations * strength * self._noise + self._spike
        return limited(positions, self._before, most)
