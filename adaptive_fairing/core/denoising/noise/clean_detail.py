"""Detail of clean meshes that is as rough as noise in every contrast."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..parameters import parameters
from .noisy_surface import NoisySurface
from .repeats import repeated_part


class CleanDetail:
    """Signs by which the detail of a clean mesh differs from noise.

    Parameters
    ----------
    surface : NoisySurface
    is_counted : (n,) bool
        Vertices of the whole mesh to judge from.
    """

    def __init__(self, surface: NoisySurface, is_counted: BoolArray) -> None:
        self._surface, self._all_counted = surface, is_counted

    def fades(self, is_counted: BoolArray) -> bool:
        """Whether vertices, (n,) bool, have detail as fine as the mesh.

        Such detail fades in differences of higher order, while white noise does not.
        """
        fading = self._surface.fading
        rough, _ = fading.of_mesh(is_counted)
        return fading.fades(is_counted) and rough < parameters().least_roughness

    def copies(self, is_counted: BoolArray) -> str:
        """Text on the exact copies among the triangles at vertices, (n,) bool; "" without any.

        Meshes of a camera or a scanner with rounded depths have copies too.
        """
        surface, triangles = self._surface, self._surface.topology.triangles
        if surface.cosines is not None:
            return ""
        some = triangles[is_counted[triangles].any(axis=1)]
        part = repeated_part(some, surface.positions)
        return f"{100 * part:.0f} % of its triangles are exact copies of others" if part else ""

    def bends(self, is_counted: BoolArray) -> str:
        """Text on signs that vertices, (n,) bool, belong to a bent low-poly model; "" without any.

        Small parts, such as the eyes of a head, go with the whole.
        """
        tuned = parameters()
        if np.count_nonzero(is_counted) < tuned.fewest_to_tell:
            return self._of_whole
        _, kept = self._surface.fading.of_mesh(is_counted)
        return self._said_of(is_counted) if kept > tuned.least_kept else ""

    @cached_property
    def _of_whole(self) -> str:
        return self._said_of(self._all_counted)

    def _said_of(self, is_counted: BoolArray) -> str:
        """Text on signs that vertices, (n,) bool, are a bent low-poly shape; "" without any.

        The measure is the deviation of a vertex from the mean of its neighbours.  In white noise it
        is independent of the neighbours' deviations; on a smooth shape they are nearly equal.
        """
        tuned = parameters()
        if np.count_nonzero(self._all_counted) > tuned.low_poly:
            return ""
        surface, frame = self._surface, self._surface.frame
        of_white = frame.rises(frame.raised(surface.fading.white))
        of_mesh, of_noise = (
            self._alikeness(rises, is_counted) for rises in (surface.own.rises, of_white)
        )
        alike = (of_mesh - of_noise) / max(1 - of_noise, 1e-9)
        if alike < tuned.least_bend_correlation:
            return ""
        return (
            f"neighbouring vertices stand out alike by {100 * alike:.0f} %, as where a shape bends"
        )

    def _alikeness(self, own: FloatArray, is_counted: BoolArray) -> float:
        """Correlation of the deviations (n,) from the neighbours' mean with the neighbours'."""
        around = self._surface.frame.mean @ own
        own, around = own[is_counted], around[is_counted]
        size = float(own.std() * around.std())
        return float(np.mean((own - own.mean()) * (around - around.mean()))) / size if size else 0.0
