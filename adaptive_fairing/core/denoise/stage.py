"""A surface before it is filtered, with all that the automatic method needs of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..fem.loop_space import LoopSpace
from ..linalg.conjugate_gradients import SolveReport
from ..runtime.arrays import BoolArray, FloatArray
from .creases import has_creases
from .filter_bank import FilterBank
from .filter_rounds import rounds_for
from .local_frame import LocalFrame
from .mesh_parts import MeshParts
from .noise.correlation import NoiseCorrelation
from .noise.face_noise import FaceNoise, face_noise
from .noise.level import beyond_clean
from .noise.noisy_surface import NoisySurface
from .noise.spikes import without_spikes
from .parameters import parameters
from .plan import DenoisePlan
from .progress import ProgressReport
from .track import Track


class Stage:
    """Positions with all that the method needs of them before the noise is known."""

    def __init__(
        self,
        space: LoopSpace,
        positions: FloatArray,
        is_still: BoolArray,
        on_solve: Callable[[SolveReport], None],
    ) -> None:
        self._space, self._is_still, self._on_solve = space, is_still, on_solve
        self.bank = FilterBank(space.topology, positions, on_solve)
        self.track = Track(self.bank, positions)
        self.frame = LocalFrame.of(space.topology, self.track.surface, self.track.surface)
        self.noisy = NoisySurface(space.topology, positions, self.frame)
        self.parts = MeshParts(space.topology, self.frame, is_still)

    def calmed(self, impulsive: FloatArray) -> Stage:
        """Put vertices back that stand out, by a part (n,) of their way."""
        positions = self.track.positions
        calm = without_spikes(self.noisy, self.parts.is_counted, self.parts.may_move)
        start = positions + impulsive[:, None] * (calm - positions)
        return Stage(self._space, start, self._is_still, self._on_solve)

    def face_noise(self, noisy: NoisySurface) -> FaceNoise:
        """Measure the smooth noise on flat faces, in the surface's units."""
        tuned, positions = parameters(), self.track.positions
        assumed = NoiseCorrelation(deviation=tuned.assumed_deviation, passes=tuned.assumed_passes)
        faces = self.bank.flat_faces(positions, self.track.surface, assumed)
        return face_noise(noisy, faces, self.parts.is_counted)

    def undented(self, level: FloatArray, impulsive: FloatArray) -> FloatArray | None:
        """Make flat faces flat, where low spikes left dents, by a part (n,) of the way.

        None where that is not all there is to do: where spikes were not the noise, or the level
        (n,) of the rest is more than that of clean meshes, or there are no flat faces.
        """
        judged = level[level > 0]
        is_clean = not len(judged) or not beyond_clean(np.median(judged, keepdims=True)).any()
        start = calm = self.track.positions
        if not (impulsive.any() and is_clean and has_creases(self.bank.topology, start)):
            return None
        for _ in range(parameters().undenting_rounds):
            flat = self.bank.flattened(calm, calm, parameters().least_flat_dented)
            if flat is None:
                return None
            calm = flat
        result: FloatArray = start + impulsive[:, None] * (calm - start)
        return result

    def repeat(self, plan: DenoisePlan, progress: ProgressReport) -> None:
        """Filter as on another frame of the surface."""
        first, *others = rounds_for(plan.noise, plan.correlation)
        progress.begin("filter", 1)
        self.track.filter(first)
        # Without creases there was no last round.
        for number, (families, pilot) in enumerate(zip(others, plan.pilots, strict=False), start=2):
            progress.begin("filter", number)
            self.track.surface = self.track.mixed(pilot)
            self.track.filter(families)
