"""A surface with noise, and what several measures of the noise read of it, each computed once."""

from __future__ import annotations

from functools import cached_property

from ...mesh.topology import TriangleTopology
from ...runtime.arrays import FloatArray
from ..local_frame import LocalFrame
from .line_roughness import LineRoughness
from .order_decay import Fading
from .own_numbers import LINE_NOISE, WHITE_NOISE, OwnNumbers


class NoisySurface:
    """What the noise is judged from.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
    frame : LocalFrame
    """

    def __init__(
        self, topology: TriangleTopology, positions: FloatArray, frame: LocalFrame
    ) -> None:
        self.topology, self.positions, self.frame = topology, positions, frame

    @cached_property
    def own(self) -> OwnNumbers:
        """Numbers that look random but belong to the surface."""
        return OwnNumbers(self.positions, self.frame)

    @cached_property
    def fading(self) -> Fading:
        """How the roughness fades in differences of higher order."""
        return Fading(self.positions, self.frame, self.own.noise(WHITE_NOISE))

    @cached_property
    def lines(self) -> LineRoughness:
        """Deviations from the smoothest line through each vertex."""
        noise = self.own.noise(LINE_NOISE)
        return LineRoughness(self.topology, self.positions, self.frame, noise)
