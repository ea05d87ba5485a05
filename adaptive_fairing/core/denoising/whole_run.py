"""Run on a whole surface, from which runs on its parts take their results.

The filters are mixed for all vertices together.  Mixed for a hundredth of them, they remove
something else: it differs by 24 to 41 % of what is removed.  So the first run on a part denoises
the whole, and later ones only look up where its vertices go.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..fem.memory_estimate import MemoryNeededError
from ..problem.prepared_mesh import PreparedMesh
from ..problem.problem import SolverProblem
from ..runtime.arrays import BoolArray, FloatArray, RealArray, SingleArray
from .mixing import MixedSurfaces
from .plan import STRENGTHS, DenoisePlan
from .progress import ProgressReport
from .settings import DenoiseSettings
from .triangle_surface import TriangleSurface
from .wide_noise import denoised_surfaces

# Larger surfaces are not denoised for the sake of a part: it would take minutes.
LARGEST_WHOLE = 1_000_000

# A part is like the whole if the fraction of the noise that was removed there is at most so many
# times that of the whole, and at least its inverse.
MOST_UNLIKE = 1.5


@dataclass
class WholeRun:
    """Result of a run on the whole surface, for runs on parts of it.

    Attributes
    ----------
    settings : DenoiseSettings
    start : (n, 3)
        Positions before, in object units.
    shown : (n, 3)
        Positions after the last run on a part.
    moves : (k, n, 3)
        Displacements for all of `STRENGTHS`.
    share : (n,)
        Displacement at strength 1 over the size of the noise; 0 where none was found.
    outcome : MixedSurfaces
        All of the result but the positions.
    """

    settings: DenoiseSettings
    start: FloatArray
    shown: FloatArray
    moves: SingleArray
    share: RealArray
    outcome: MixedSurfaces

    @property
    def plan(self) -> DenoisePlan:
        """Plan of the whole surface."""
        return self.outcome.plan

    def serves(self, positions: FloatArray, settings: DenoiseSettings) -> bool:
        """Whether it is of this surface, (n, 3), but for some edited places."""
        if _without_limit(settings) != self.settings:
            return False
        is_known = _are_same(positions, self.shown) | _are_same(positions, self.start)
        return bool(is_known.mean() > 0.5)

    def at_part(
        self, problem: SolverProblem, positions: FloatArray, is_judged: BoolArray
    ) -> MixedSurfaces | None:
        """Look up the result for a part.

        Parameters
        ----------
        problem : SolverProblem
            On the part.
        positions : (n, 3)
            Of the whole surface now, in object units.
        is_judged : (k,) bool
            Vertices of the part that tell whether it is like the whole.

        Returns
        -------
        MixedSurfaces or None
            None if the part was edited since, or its noise is unlike that of the whole.
        """
        part = problem.whole.part
        start, shown, now = (each[part] for each in (self.start, self.shown, positions))
        was_denoised = (shown != start).any(axis=1) & (problem.weights == 0)
        is_known = was_denoised | _are_same(now, shown) | _are_same(now, start)
        if not (is_known.all() and self._is_alike(self.share[part][is_judged])):
            return None
        ways = self.moves[:, part] + (start - now)
        return replace(
            self.outcome,
            positions=list(problem.start + problem.whole.frame.scale * ways),
            plan=self.plan.at(part),
        )

    def note_result(self, positions: FloatArray, weights: FloatArray) -> None:
        """Note where a run on a part has moved the surface, (n, 3), with weights (n,)."""
        self.shown[weights > 0] = positions[weights > 0]

    def _is_alike(self, share: RealArray) -> bool:
        """Whether a fraction of the noise was removed that is usual, at some vertices."""
        usual, here = (
            float(np.median(each[each > 0])) if each.any() else 0.0 for each in (self.share, share)
        )
        return usual < MOST_UNLIKE * here < MOST_UNLIKE**2 * usual


def whole_run(
    problem: SolverProblem,
    prepared: PreparedMesh,
    positions: FloatArray,
    settings: DenoiseSettings,
    progress: ProgressReport,
) -> WholeRun | None:
    """Return the run on the whole that is kept with a mesh, or make and keep it.

    Parameters
    ----------
    problem : SolverProblem
        On a part of the surface.
    prepared : PreparedMesh
    positions : (n, 3)
        Of the whole surface, in object units.
    settings : DenoiseSettings
    progress : ProgressReport

    Returns
    -------
    WholeRun or None
        None if the surface is too large.
    """
    kept = prepared.whole_run
    if isinstance(kept, WholeRun) and kept.serves(positions, settings):
        return kept
    prepared.whole_run = None  # before the next one takes its memory
    whole = problem.whole
    topology, frame = whole.topology, whole.frame
    try:
        if topology.n_triangles > LARGEST_WHOLE:
            return None
        prepared.admit("denoise")
    except MemoryNeededError:
        return None
    outcome = denoised_surfaces(
        topology, whole.start, frame.surface.is_cut, settings, progress=progress
    )
    moves = np.stack([each - whole.start for each in outcome.positions])
    size = outcome.plan.noise * TriangleSurface(topology, whole.start).spacing
    moved = np.linalg.norm(moves[STRENGTHS.index(1.0)], axis=1)
    run = WholeRun(
        settings=_without_limit(settings),
        start=positions,
        shown=positions.copy(),
        moves=(moves / frame.scale).astype(np.float32),
        share=np.divide(moved, size, out=np.zeros_like(size), where=size > 0),
        outcome=replace(outcome, positions=[]),
    )
    prepared.whole_run = run
    return run


def _without_limit(settings: DenoiseSettings) -> DenoiseSettings:
    """Leave out the largest deviation, which is applied to the result of the run."""
    return replace(settings, max_deviation=None)


def _are_same(one: FloatArray, other: FloatArray) -> BoolArray:
    """Whether positions (n, 3) agree, (n,), in single precision: a caller may keep them in it."""
    same: BoolArray = (one.astype(np.float32) == other.astype(np.float32)).all(axis=1)
    return same
