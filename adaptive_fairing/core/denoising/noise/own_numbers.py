"""Pseudo-random numbers that follow from the geometry alone.

The automatic method adds a little noise of its own to measure what the filters do with noise.
Numbers from a generator would go with the numbering of the vertices, so that a turned or renumbered
mesh would get other ones.  Here each vertex gets its number from lengths around it and from its
distances to the principal planes of the mesh, which no turn, reflection, renumbering or reversal of
the faces changes.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from ...mesh.normals import dots
from ...runtime.arrays import FloatArray
from ..triangle_surface import TriangleSurface

# Turns of the phase per local edge length.  Noise of 0.05 of an edge moves the phase by several
# turns, so neighbours are not alike; rounding to single precision moves it by a thousandth.
TURNS = (61.0, 37.0 * np.sqrt(2))
TURNS_FROM_PLANES = (31.0 * np.sqrt(3), 29.0 * np.sqrt(5), 23.0 * np.sqrt(7))
MIXING = 13.0

# Different numbers for different uses: added to the turns.
PROBE, WHITE_NOISE, LINE_NOISE = 0.0, 7.3, 12.9


class OwnNumbers:
    """The numbers of a mesh; other ones for each use.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface

    Attributes
    ----------
    rises : (n,)
        How far each vertex lies over the mean of its neighbours, see `TriangleSurface.rises`.
    """

    def __init__(self, positions: FloatArray, frame: TriangleSurface) -> None:
        self.rises = frame.rises(positions)
        # Loose vertices belong to no surface, and must not change its numbers.
        used = ~frame.topology.is_loose
        centred = positions - positions[used].mean(axis=0)
        around = frame.mean @ centred
        square = dots(centred, centred)
        spread = square + frame.mean @ square - 2 * dots(centred, around)
        self._to_middle = np.linalg.norm(centred - around, axis=1) / frame.spacing
        self._spread = spread / frame.spacing**2
        # Where a mesh is exactly regular, the lengths around its vertices are all the same.
        # Products, because a phase that is linear in the position would be a wave on a lattice.
        _, axes = np.linalg.eigh(centred[used].T @ centred[used])
        from_planes = np.abs(centred @ axes) * TURNS_FROM_PLANES / np.mean(frame.spacing[used])
        waves = np.abs(2 * (from_planes - np.floor(from_planes)) - 1)
        self._waves = MIXING * np.einsum("nk,nk->n", waves, np.roll(waves, 1, axis=1))

    def phases(self, use: float) -> FloatArray:
        """Return numbers in [0, 1), (n,), for `PROBE`, `WHITE_NOISE` or `LINE_NOISE`."""
        turns = (TURNS[0] + use) * self._to_middle + (TURNS[1] + use) * self._spread
        turns += self._waves
        phases: FloatArray = turns - np.floor(turns)
        return phases

    def probe(self) -> FloatArray:
        """Return numbers of mean 0 and mean square 1, (n,), for steps along the normals.

        Signs alone would leap where rounding moves a phase past its end.  A number changes its
        sign with the normal, so that the step is the same if the faces are turned over.
        """
        waves = np.cos(2 * np.pi * self.phases(PROBE)) * self._sides
        probe: FloatArray = waves / np.sqrt(np.mean(np.square(waves)))
        return probe

    def noise(self, use: float) -> FloatArray:
        """Return normal-distributed numbers of unit variance, (n,), for heights along normals."""
        noise: FloatArray = ndtri(np.clip(self.phases(use), 1e-9, 1 - 1e-9)) * self._sides
        return noise

    @property
    def _sides(self) -> FloatArray:
        return np.where(self.rises < 0, -1.0, 1.0)
