"""What looks like noise on a clean mesh: detail, creases everywhere, low-poly shapes."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...mesh.topology import TriangleTopology
from ...runtime.arrays import BoolArray, FloatArray
from ..local_frame import LocalFrame
from .correlation import LEAST_ROUGHNESS
from .level import CLEAN_ROUGHNESS
from .line_roughness import LineRoughness
from .order_decay import Fading
from .repeats import repetition

# A mesh with creases everywhere is clean if along them it is no rougher than clean meshes are, and
# this share of its vertices no rougher than this, in local edge lengths of noise.
SMOOTH_SHARE, CORNER_ROUGHNESS = 0.9, 0.3

# Up to so many vertices a shape may be bent as sharply as its edges allow. It is taken for a model
# if neighbours share this part of how they stand out: white noise shares none, smooth shapes all.
# Decimated and modelled shapes of 400 to 3000 vertices share 0.65 to 0.95 and are rough by up to
# 0.25 of an edge; with noise of 0.2 of an edge they share at most 0.58, unless they are slivers
# that seem rough by 0.8. What fades more than to 0.7 is smoother than the edges allow.
LOW_POLY, SHARED_BEND, ROUGHEST_MODEL, LEAST_KEPT = 3000, 0.6, 0.4, 0.75
SMALL = 300

# Spikes at every fifth vertex leave half of the triangles of a model as they were.
LEFT_BY_SPIKES = 0.6

# Levels of a clean mesh may lie above what clean meshes have at this part of its vertices: those
# with much shorter edges than others.
FEW = 0.1


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
    topology : TriangleTopology
    positions : (n, 3)
    frame : LocalFrame
    fading : Fading
    is_counted : (n,) bool
        Vertices of the whole mesh that can be judged from.
    """

    def __init__(
        self,
        topology: TriangleTopology,
        positions: FloatArray,
        frame: LocalFrame,
        fading: Fading,
        is_counted: BoolArray,
    ) -> None:
        self._topology, self._positions, self._frame = topology, positions, frame
        self._fading, self._all_counted = fading, is_counted

    def found(self, level: FloatArray, is_counted: BoolArray, is_impulsive: bool) -> Found:
        """Tell what the roughness of some vertices, (n,) bool, is.

        Parameters
        ----------
        level : (n,)
            Noise in local edge lengths, as the roughness tells it.
        is_impulsive : bool
            Whether the roughness is that of single vertices.
        """
        if np.quantile(level[is_counted], 1 - FEW) <= CLEAN_ROUGHNESS:
            return DETAIL
        of_part = is_counted[self._topology.triangles].any(axis=1)
        repeated = repetition(self._topology.triangles[of_part], self._positions)
        # Spikes leave the triangles between them as they were.
        is_model = repeated.part > (LEFT_BY_SPIKES if is_impulsive else 0)
        if is_model and not repeated.is_contour:
            return Found(
                is_model=True,
                reason=f"{100 * repeated.part:.0f} % of its triangles are exact copies of others",
            )
        # Creases everywhere look like noise to the level; along them all may be smooth, but for the
        # few places where they meet.  Contoured voxels have more of these.
        is_smooth = self._lines.level(is_counted) <= CLEAN_ROUGHNESS
        if is_smooth and self._lines.level(is_counted, SMOOTH_SHARE) <= CORNER_ROUGHNESS:
            return DETAIL
        # Detail as fine as the mesh fades, while white noise does not.
        rough, kept = self._fading.of_mesh(is_counted)
        if self._fading.fades(is_counted) and rough < LEAST_ROUGHNESS:
            return DETAIL
        # Small parts, such as the eyes of a head, go with the whole.
        is_small = np.count_nonzero(is_counted) < SMALL
        is_mild = kept > LEAST_KEPT and np.median(level[is_counted]) < ROUGHEST_MODEL
        may_be_model = is_small or is_mild
        if may_be_model and not repeated.is_contour and self._bends:
            return Found(is_model=True, reason=self._bends)
        return NOISE

    @cached_property
    def _bends(self) -> str:
        """What tells that the whole mesh is a low-poly shape that bends; empty if it is none.

        Of what makes a vertex stand out from its neighbours' mean, noise shares nothing with the
        same at the neighbours, and a smooth shape nearly all.
        """
        if np.count_nonzero(self._all_counted) > LOW_POLY:
            return ""
        of_mesh, of_noise = (
            self._alikeness(values)
            for values in (self._positions, self._frame.raised(self._fading.white))
        )
        shared = (of_mesh - of_noise) / max(1 - of_noise, 1e-9)
        if shared < SHARED_BEND:
            return ""
        return (
            f"neighbouring vertices stand out alike by {100 * shared:.0f} %, as where a shape bends"
        )

    def _alikeness(self, values: FloatArray) -> float:
        """Correlation of the deviations from the neighbours' mean with those of the neighbours."""
        frame = self._frame
        own = frame.along_normal(values - frame.mean @ values)
        around = frame.mean @ own
        own, around = own[self._all_counted], around[self._all_counted]
        size = float(own.std() * around.std())
        return float(np.mean((own - own.mean()) * (around - around.mean()))) / size if size else 0.0

    @cached_property
    def _lines(self) -> LineRoughness:
        return LineRoughness(self._topology, self._positions, self._frame)
