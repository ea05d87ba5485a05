"""What looks like noise on a clean mesh: detail, creases everywhere, low-poly shapes."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..parameters import parameters
from .noisy_surface import NoisySurface
from .repeats import repetition


class Found(NamedTuple):
    """What the roughness of a part of a mesh is.

    Attributes
    ----------
    is_noise, is_model : bool
        Noise; or the shape of a low-poly model. If neither, the detail that clean meshes have.
    reason : str
        What tells a model, for the user.
    """

    is_noise: bool = False
    is_model: bool = False
    reason: str = ""


NOISE, DETAIL = Found(is_noise=True), Found()


class CleanDetail:
    """What tells the detail of a clean mesh from noise.

    Parameters
    ----------
    surface : NoisySurface
    is_counted : (n,) bool
        Vertices of the whole mesh that can be judged from.
    """

    def __init__(self, surface: NoisySurface, is_counted: BoolArray) -> None:
        self._surface, self._all_counted = surface, is_counted

    def found(self, level: FloatArray, is_counted: BoolArray, is_impulsive: bool) -> Found:
        """Tell what the roughness of some vertices, (n,) bool, is.

        Parameters
        ----------
        level : (n,)
            Noise in local edge lengths, as the roughness tells it.
        is_impulsive : bool
            Whether the roughness is that of single vertices.
        """
        tuned, surface = parameters(), self._surface
        if np.quantile(level[is_counted], 1 - tuned.rough_fraction) <= tuned.clean_roughness:
            return DETAIL
        triangles = surface.topology.triangles
        repeated = repetition(triangles[is_counted[triangles].any(axis=1)], surface.positions)
        # Spikes leave the triangles between them as they were.
        is_model = repeated.part > (tuned.left_by_spikes if is_impulsive else 0)
        if is_model and not repeated.is_contour:
            return Found(
                is_model=True,
                reason=f"{100 * repeated.part:.0f} % of its triangles are exact copies of others",
            )
        # Creases everywhere look like noise to the level; along them all may be smooth, but for the
        # few places where they meet.  Contoured voxels have more of these.
        is_smooth = surface.lines.level(is_counted) <= tuned.clean_roughness
        corners = surface.lines.level(is_counted, tuned.smooth_fraction)
        if is_smooth and corners <= tuned.corner_roughness:
            return DETAIL
        # Detail as fine as the mesh fades, while white noise does not.
        rough, kept = surface.fading.of_mesh(is_counted)
        if surface.fading.fades(is_counted) and rough < tuned.least_roughness:
            return DETAIL
        # Small parts, such as the eyes of a head, go with the whole.
        is_small = np.count_nonzero(is_counted) < tuned.small_part
        is_mild = kept > tuned.least_kept and np.median(level[is_counted]) < tuned.roughest_model
        may_be_model = is_small or is_mild
        if may_be_model and not repeated.is_contour and self._bends:
            return Found(is_model=True, reason=self._bends)
        return NOISE

    @cached_property
    def _bends(self) -> str:
        """What tells that the whole mesh is a low-poly shape that bends; empty if it is none.

        Measured is how far a vertex stands out from the mean of its neighbours.  In white noise
        this is independent of how far the neighbours stand out; on a smooth shape it is nearly the
        same.
        """
        tuned = parameters()
        if np.count_nonzero(self._all_counted) > tuned.low_poly:
            return ""
        surface, frame = self._surface, self._surface.frame
        of_white = frame.rises(frame.raised(surface.fading.white))
        of_mesh, of_noise = (self._alikeness(rises) for rises in (surface.own.rises, of_white))
        alike = (of_mesh - of_noise) / max(1 - of_noise, 1e-9)
        if alike < tuned.least_bend_correlation:
            return ""
        return (
            f"neighbouring vertices stand out alike by {100 * alike:.0f} %, as where a shape bends"
        )

    def _alikeness(self, own: FloatArray) -> float:
        """Correlation of the deviations (n,) from the neighbours' mean with the neighbours'."""
        around = self._surface.frame.mean @ own
        own, around = own[self._all_counted], around[self._all_counted]
        size = float(own.std() * around.std())
        return float(np.mean((own - own.mean()) * (around - around.mean()))) / size if size else 0.0
