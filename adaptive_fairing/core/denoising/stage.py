"""Stage of a run: a surface before it is filtered, and while it passes the filters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..linalg.conjugate_gradients import SolveReport
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray, RealArray
from ..runtime.threads import side_by_side
from .filters import Filter, FilterBank, FlatFamily, Round, rounds_for
from .mesh_parts import MeshParts
from .mixture import Mixture
from .noise.face_noise import face_noise
from .noise.noisy_surface import NoisySurface
from .noise.own_numbers import WHITE_NOISE, Colours, OwnNumbers
from .noise.smooth_noise import SmoothNoise
from .noise.spikes import without_spikes
from .noise_model import averaged_noise
from .parameters import parameters
from .plan import DenoisePlan
from .progress import ProgressReport
from .triangle_surface import TriangleSurface


class Track:
    """A surface while it passes the filters, with the part that each filter removes.

    The removed parts are stored in single precision, which suffices, to save memory.

    Parameters
    ----------
    bank : FilterBank
    start : TriangleSurface
        Surface to filter.

    Attributes
    ----------
    surface : TriangleSurface
        Surface from which the next filters take their metrics and normals.
    taken : dict of Filter to (n, 3)
    """

    def __init__(self, bank: FilterBank, start: TriangleSurface) -> None:
        self._bank, self.start = bank, start
        self.surface, filtered = bank.started(start)
        self.taken: dict[Filter, RealArray] = {
            each: self._taken_by(result) for each, result in filtered.items()
        }

    def mix(self, pilot: Mixture) -> None:
        """Take the metrics and normals of the next filters from a mixture of those so far."""
        self.surface = TriangleSurface(self.start.topology, self.mixed(pilot))

    def with_faces(self, families: Round) -> Round:
        """Find the flat faces of the surface for those of the next filters that flatten them."""
        return tuple(
            each.found(self._bank, self.start, self.surface)
            if isinstance(each, FlatFamily)
            else each
            for each in families
        )

    def filter(self, families: Round) -> None:
        """Add the filters of a round."""
        for each, result in self._bank.filtered(self.start, self.surface, families):
            self.taken[each] = self._taken_by(result)

    def repeat(self, plan: DenoisePlan, progress: ProgressReport) -> None:
        """Filter in the same way as another frame of the surface."""
        self._bank.know_noise(plan.noise)
        rounds = rounds_for(plan.typical_noise, plan.correlation)
        pilots = (None, *plan.pilots)
        for number, (families, pilot) in enumerate(zip(rounds, pilots, strict=True), start=1):
            progress.begin("filter", number)
            if pilot is not None:
                self.mix(pilot)
            self.filter(families)

    def removed(self, each: Filter, frame: TriangleSurface) -> FloatArray:
        """Measure the normal component (n,) of the part that a filter removes, in local edges."""
        return frame.along_normal(self.taken[each].astype(np.float64))

    def mixed(self, mixture: Mixture) -> FloatArray:
        """Mix the filters so far."""
        result, taken = self.start.positions.copy(), list(self.taken.values())
        for used in mixture.used:
            result -= mixture.coefficients(used)[:, None] * taken[used]
        return result

    def _taken_by(self, result: FloatArray) -> RealArray:
        return (self.start.positions - result).astype(np.float32)


class Stage:
    """A surface with everything that the method needs before the noise is known.

    Attributes
    ----------
    bank : FilterBank
    track : Track
    frame : TriangleSurface
        The surface, slightly smoothed: unit of length and direction of the noise.
    noisy : NoisySurface
    parts : MeshParts
    spikes : (n,)
        How far each vertex was a spike that was put back, 0 to 1.
    """

    def __init__(
        self,
        topology: TriangleTopology,
        positions: FloatArray,
        is_still: BoolArray,
        on_solve: Callable[[SolveReport], None],
        own: OwnNumbers | None = None,
        spikes: FloatArray | None = None,
    ) -> None:
        self._is_still, self._on_solve = is_still, on_solve
        self.spikes = np.zeros(len(positions)) if spikes is None else spikes
        start = TriangleSurface(topology, positions)
        # What is made side by side here is made by one thread each.
        self.bank, colours = side_by_side(
            lambda: FilterBank(start, on_solve),
            lambda: None if own else Colours.of(topology),
        )
        self.track = Track(self.bank, start)
        frame = self.frame = self.track.surface
        self.noisy, self.parts = side_by_side(
            lambda: NoisySurface(positions, frame, own or OwnNumbers(positions, frame, colours)),
            lambda: MeshParts(frame, is_still),
        )

    def calmed(self, impulsive: BoolArray) -> Stage:
        """Put spikes back among some vertices, (n,)."""
        positions = self.noisy.positions
        calm, spikes = without_spikes(self.noisy, self.parts.is_counted, self.parts.may_move)
        start = np.where(impulsive[:, None], calm, positions)
        own, spikes = self.noisy.own, np.where(impulsive, spikes, 0)
        return Stage(self.frame.topology, start, self._is_still, self._on_solve, own, spikes)

    def face_noise(self, noisy: NoisySurface) -> SmoothNoise | None:
        """Measure the smooth noise on flat faces, in the surface's units; None without any."""
        white, counted = self.noisy.own.noise(WHITE_NOISE), self.parts.is_counted
        _, assumed = averaged_noise(white, parameters().assumed_passes, self.frame, counted)
        faces = self.bank.flat_faces(self.track.start, self.frame, assumed)
        return face_noise(noisy, faces, counted)
