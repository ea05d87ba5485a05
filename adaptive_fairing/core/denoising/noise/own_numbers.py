"""Pseudo-random numbers that follow from the geometry alone.

The automatic method adds a little noise of its own to measure the effect of the filters on noise.
Numbers from a generator would depend on the numbering of the vertices, so that a renumbered mesh
would get others.  Here the number of a vertex follows from lengths around it and from its distance
to the centre of the mesh, which no rotation, reflection, renumbering or reversal of the faces
changes.  A slightly different mesh gets slightly different numbers, so that rounding does not
decide the result.
"""

from __future__ import annotations

from itertools import islice

import numpy as np
from scipy.special import ndtri

from ...mesh.normals import dots
from ...runtime.arrays import FloatArray
from ..triangle_surface import TriangleSurface

# Turns of the phase per local edge length, from lengths around a vertex.  Noise of 0.1 of an edge
# moves the phase by some turns, so neighbours are not alike; jitter of 0.0001 by some thousandths.
TURNS = (24.0, 15.0 * np.sqrt(2))
# Turns per squared edge length, from the distance to the centre.  Where a mesh is exactly regular,
# the lengths around its vertices are all the same.  The square makes waves of all lengths; a phase
# that is linear in the position would be one wave on a lattice.
TURNS_FROM_CENTRE = 0.02 * np.sqrt(3)

# A probe takes at most this many turns for the noise.  Where that is strong neighbours are not
# alike with fewer turns, and more would only enlarge what rounding changes.  With 0.5 to 1.3 the
# errors were the same.
TURNS_OF_NOISE = 0.9

# Different numbers for different uses: so many times the turns.  Fewest for the probe, which
# decides what is mixed; noise to compare with must be even everywhere.
PROBE, WHITE_NOISE, LINE_NOISE, SEEDS = 1.0, 4.3, 3.1, 9.7


class OwnNumbers:
    """The numbers of a mesh, different for each use.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface

    Attributes
    ----------
    rises : (n,)
        Height of each vertex over the mean of its neighbours, see `TriangleSurface.rises`.
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
        self._from_centre = square / np.mean(frame.spacing[used]) ** 2
        self._typical_rise = float(np.median(np.abs(self.rises[used])))

    def phases(self, use: float, part: float = 1.0) -> FloatArray:
        """Return numbers in [0, 1), (n,), for `PROBE`, `WHITE_NOISE`, `LINE_NOISE` or `SEEDS`.

        From a part of the usual turns, 0 to 1, if wanted.
        """
        turns = part * (TURNS[0] * self._to_middle + TURNS[1] * self._spread)
        turns = use * (turns + TURNS_FROM_CENTRE * self._from_centre)
        phases: FloatArray = turns - np.floor(turns)
        return phases

    def probes(self, count: int, noise: float) -> list[FloatArray]:
        """Return one to four rows of numbers (n,) for steps along the normals.

        Each has mean 0 and mean square 1, and they are not correlated: sines and cosines of
        multiples of the phases.  Mere signs would jump where rounding moves a phase past its end.
        A number changes its sign with the normal, so that the step is the same if the faces are
        reversed.

        Noise of a typical size in local edge lengths moves vertices apart by that, unless it is
        smooth: then they rise less over their neighbours.
        """
        apart = max(min(noise, self._typical_rise), 1e-9)
        turns = 2 * np.pi * self.phases(PROBE, min(1.0, TURNS_OF_NOISE / (TURNS[0] * apart)))
        waves = ((wave, times) for times in (1, 2) for wave in (np.cos, np.sin))
        signed = (wave(times * turns) * self._sides for wave, times in islice(waves, count))
        return [each / np.sqrt(np.mean(np.square(each))) for each in signed]

    def noise(self, use: float) -> FloatArray:
        """Return normal-distributed numbers of unit variance, (n,), for heights along normals."""
        noise: FloatArray = ndtri(np.clip(self.phases(use), 1e-9, 1 - 1e-9)) * self._sides
        return noise

    @property
    def _sides(self) -> FloatArray:
        return np.where(self.rises < 0, -1.0, 1.0)
