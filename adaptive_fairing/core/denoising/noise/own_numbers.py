"""Pseudo-random numbers that follow from the mesh alone.

The automatic method adds a little noise of its own to measure the effect of the filters on noise.
Numbers from a generator would depend on the numbering of the vertices, so that a renumbered mesh
would get others.  Here the number of a vertex follows from the connectivity around it: how many
neighbours it has, how many those have, and so on.  No rotation, reflection, renumbering or reversal
of the faces changes it, and no jitter or rounding of positions either.

Where connectivity is regular, neighbours see the same around them.  There the number follows from
lengths around the vertex and from its distance to the centre of the mesh.
"""

from __future__ import annotations

from itertools import islice
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from ...mesh.normals import dots
from ...mesh.topology import TriangleTopology
from ...runtime.arrays import BoolArray, FloatArray
from ..parameters import parameters
from ..triangle_surface import TriangleSurface

# Rings of neighbours that are seen.  Four tell apart all vertices of most scans and remeshed
# models; this many also those between the vertices of a coarse mesh that was subdivided.
RINGS = 16

# Turns for the connectivity, so many that the phases of all uses are random.
MOST_TURNS = 1e6

# Turns of the phase per local edge length, from lengths around a vertex.  Noise of 0.1 of an edge
# moves the phase by some turns, so neighbours are not alike; jitter of 0.0001 by some thousandths.
TURNS = (24.0, 15.0 * np.sqrt(2))
# Turns per squared edge length, from the distance to the centre.  Where a mesh is exactly regular,
# the lengths around its vertices are all the same.  The square makes waves of all lengths; a phase
# that is linear in the position would be one wave on a lattice.
TURNS_FROM_CENTRE = 0.02 * np.sqrt(3)

# Different numbers for different uses: so many times the turns.  Fewest for the probe, which
# decides what is mixed; noise to compare with must be even everywhere.
PROBE, WHITE_NOISE, LINE_NOISE, SEEDS = 1.0, 4.3, 3.1, 9.7
# Those that a mesh is compared with where one random noise differs too much from the next.
SEVERAL_NOISES = WHITE_NOISE, LINE_NOISE, SEEDS


class Colours(NamedTuple):
    """Random numbers from the connectivity around vertices, (n,), and which of them occur once."""

    numbers: FloatArray
    is_unique: BoolArray

    @classmethod
    def of(cls, topology: TriangleTopology) -> Self:
        """Find the colours of a mesh.

        Source: colour refinement, B. Weisfeiler and A. Leman, 1968, with hash values as colours.
        """
        sizes, ring = topology.ring_size, topology.ring
        is_used = sizes > 0
        first = topology.ring_start[:-1][is_used]
        colours = hashed((2 * sizes + topology.on_boundary).astype(np.uint64))
        for _ in range(RINGS):
            around = np.add.reduceat(hashed(colours)[ring], first)
            colours[is_used] = hashed(3 * colours[is_used] + around)
        _, kind, count = np.unique(colours, return_inverse=True, return_counts=True)
        return cls(colours / 2.0**64, count[kind] == 1)


class OwnNumbers:
    """The numbers of a mesh, different for each use.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface
    colours : Colours, optional
        Of the vertices, if they are known already.
    """

    def __init__(
        self, positions: FloatArray, frame: TriangleSurface, colours: Colours | None = None
    ) -> None:
        numbers, is_unique = colours or Colours.of(frame.topology)
        self._turns = np.where(is_unique, MOST_TURNS * numbers, _turns_of_lengths(positions, frame))
        # Numbers change their sign with the normals, so that their steps are the same if all faces
        # are reversed.  Where lengths hardly tell neighbours apart, their rises do.
        rises = np.where(frame.topology.is_loose, 0.0, frame.rises(positions))
        self._sides = np.where(np.where(is_unique, rises.sum(), rises) < 0, -1.0, 1.0)
        self._noises: dict[float, FloatArray] = {}

    def phases(self, use: float) -> FloatArray:
        """Return numbers in [0, 1), (n,), for `PROBE`, `WHITE_NOISE`, `LINE_NOISE` or `SEEDS`."""
        turns = use * self._turns
        phases: FloatArray = turns - np.floor(turns)
        return phases

    def probes(self, count: int) -> list[FloatArray]:
        """Return one to four rows of numbers (n,) for steps along the normals.

        Each has mean 0 and mean square 1, and they are not correlated: sines and cosines of
        multiples of the phases.  Mere signs would jump where rounding moves a phase past its end.
        """
        turns = 2 * np.pi * self.phases(PROBE)
        waves = ((wave, times) for times in (1, 2) for wave in (np.cos, np.sin))
        signed = (self._sides * wave(times * turns) for wave, times in islice(waves, count))
        return [each / np.sqrt(np.mean(np.square(each))) for each in signed]

    def noise(self, use: float) -> FloatArray:
        """Return normal-distributed numbers of unit variance, (n,), for heights along normals.

        They are kept: most measures compare with the same few noises.
        """
        if use not in self._noises:
            self._noises[use] = self._sides * ndtri(np.clip(self.phases(use), 1e-9, 1 - 1e-9))
        return self._noises[use]

    def several(self) -> list[FloatArray]:
        """Return noises to compare with: three, or one of many vertices, with little chance."""
        is_large = len(self._turns) >= parameters().least_probed
        return [self.noise(use) for use in SEVERAL_NOISES[: 1 if is_large else None]]


def hashed(values: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Mix the bits of integers (n,) of 64 bits.

    Source: G. Steele, D. Lea, C. Flood, Fast splittable pseudorandom number generators, 2014.
    """
    values = values + np.uint64(0x9E3779B97F4A7C15)
    values = (values ^ (values >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    values = (values ^ (values >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return values ^ (values >> np.uint64(31))


def _turns_of_lengths(positions: FloatArray, frame: TriangleSurface) -> FloatArray:
    """Count turns by the lengths around vertices and their distances to the centre, (n,)."""
    # Loose vertices belong to no surface, and must not change its numbers.
    used = ~frame.topology.is_loose
    centred = positions - positions[used].mean(axis=0)
    around = frame.mean @ centred
    square = dots(centred, centred)
    spread = square + frame.mean @ square - 2 * dots(centred, around)
    to_middle = np.linalg.norm(centred - around, axis=1) / frame.spacing
    turns = TURNS[0] * to_middle + TURNS[1] * spread / frame.spacing**2
    from_centre: FloatArray = square / np.mean(frame.spacing[used]) ** 2
    return turns + TURNS_FROM_CENTRE * from_centre
