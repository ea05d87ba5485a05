"""Noisy surface, with quantities that several measures of the noise share, each computed once."""

from __future__ import annotations

import numpy as np

from ...mesh.normals import dots
from ...runtime.arrays import BoolArray, FloatArray
from ...runtime.lazy import cached_property
from ..triangle_surface import TriangleSurface
from .contrast import Contrast, Fading, LineRoughness, hinges, roughness
from .level import has_one_length
from .line_of_sight import LEAST_COSINE, lines_of_sight, shows_object
from .own_numbers import LINE_NOISE, OwnNumbers


class NoisySurface:
    """Surface from which the noise is judged.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface
        The same surface, slightly smoothed: unit of length and direction of the noise.
    own : OwnNumbers, optional
        Numbers that look random but belong to the surface; its own by default.
    """

    def __init__(
        self, positions: FloatArray, frame: TriangleSurface, own: OwnNumbers | None = None
    ) -> None:
        self.positions, self.frame = positions, frame
        self.topology = frame.topology
        self.own = own or OwnNumbers(positions, frame)

    @cached_property
    def fading(self) -> Fading:
        """Decay of the roughness in differences of higher order."""
        return Fading(self.positions, self.frame, self.own.several())

    @cached_property
    def roughness(self) -> Contrast:
        """Differences of second order at the vertices."""
        return roughness(self.positions, self.frame)

    @cached_property
    def hinges(self) -> Contrast:
        """Differences between the two triangles of every edge.

        Rounded depths leave up to nearly half of them flat in the images of cameras and scanners.
        """
        found = hinges(self.positions, self.frame)
        return found if self.cosines is None else found._replace(quantile=0.5)

    @cached_property
    def lines(self) -> LineRoughness:
        """Deviations from the smoothest line through each vertex."""
        return LineRoughness(self.positions, self.frame, self.own.noise(LINE_NOISE))

    @cached_property
    def cosines(self) -> FloatArray | None:
        """Cosines (n,) of the angles at which a scanner or a camera saw the surface, if one did."""
        if self._rays is None:
            return None
        cosines: FloatArray = np.abs(dots(self.frame.normals, self._rays))
        return np.maximum(cosines, LEAST_COSINE)

    @cached_property
    def is_object(self) -> bool:
        """Whether this is an object and no terrain: it has a back, or a camera saw it."""
        twice_areas = self.frame.triangle_normals()
        total = np.linalg.norm(twice_areas, axis=1).sum()
        # The normals of a closed surface add up to nothing.
        if np.linalg.norm(twice_areas.sum(axis=0)) < total / 2:
            return True
        rays = self._rays
        return rays is not None and shows_object(self.topology, self.positions, rays)

    @cached_property
    def _rays(self) -> FloatArray | None:
        return lines_of_sight(self.topology, self.positions)

    def in_unit(self, is_counted: BoolArray) -> NoisySurface:
        """Return this surface with the unit of length in which its noise is even.

        Vertices, (n,) bool, tell whether that is one length everywhere.  If not, it goes with the
        cosines where a camera saw the surface, and is the local edge length elsewhere.  The median
        of the unit is that of the local edge length.
        """
        spacing = self.frame.spacing
        if has_one_length(self.roughness, is_counted, self.cosines):
            unit = np.ones(len(spacing))
        elif self.cosines is not None:
            unit = self.cosines
        else:
            return self
        unit = unit * (np.median(spacing) / np.median(unit))
        return NoisySurface(self.positions, self.frame.with_frame(spacing=unit), self.own)
