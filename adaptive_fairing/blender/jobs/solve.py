"""Driver of both algorithms: runs one of them on a mesh and keeps what Blender is to store.

No bpy, so that a solve can run in a thread beside Blender's window.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...core import (
    DenoisePlan,
    DenoiseProgress,
    DenoiseResult,
    DenoiseSettings,
    FairingError,
    FairingSettings,
    FairingStep,
    PreparedMesh,
    SolverError,
    SurfaceMeasures,
    denoise,
    fair_steps,
)
from ...core.problem.deviation import limited
from ...core.problem.prepared_mesh import DEFAULT_TOLERANCE
from .kept_preparation import KeptPreparation

Settings = DenoiseSettings | FairingSettings


class RunCancelledError(Exception):
    """The run was cancelled: nobody waits for its result any more."""


@dataclass
class Solve:
    """A run of one of the two algorithms on one mesh, and its result so far.

    Attributes
    ----------
    name, session_uid
        Name and number of the Blender object, if there is one. The object itself must not be kept:
        undo and deletion invalidate it.
    sharing
        Numbers of other objects that use the same mesh and are to share the result.
    is_of_level
        Whether the mesh is the shown level of a multiresolution sculpture.
    vertices, triangles, weights
        Input of `denoise` and `fair_steps`.
    settings
        Settings of one of the algorithms, which choose it.
    prepared, plan
        Preparation and plan from another frame of the same surface, see `denoise`.
    preparations
        Store in which a preparation is looked up and kept, if there is no `prepared`.
    on_fraction_done
        Called with the fraction of `denoise` that is done, 0 to 1.
    denoised
        Result of `denoise`; its shapes are float32, which is what Blender keeps.
    steps
        Finished steps of `fair_steps`, their arrays as float32.
    step_seconds
        Time that each step took, or the whole of `denoise`.
    kept
        Positions (n, 3) of the result, after `keep_result_only` has freed everything else.
    is_repeated
        Whether the result was taken from an earlier solve, without any work.
    progress
        Progress of `denoise`.
    is_cancelled
        Set to end `denoise` before it is finished.
    failed_step
        The step that did not converge, as the solver left it.
    failure
        Error that ended the run early.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    settings: Settings
    weights: NDArray[np.float64] | None = None
    prepared: PreparedMesh | None = None
    preparations: KeptPreparation | None = None
    plan: DenoisePlan | None = None
    on_fraction_done: Callable[[float], None] | None = None
    name: str = ""
    session_uid: int = 0
    sharing: tuple[int, ...] = ()
    is_of_level: bool = False
    denoised: DenoiseResult | None = None
    steps: list[FairingStep] = field(default_factory=list)
    step_seconds: list[float] = field(default_factory=list)
    kept: NDArray[np.float32] | None = None
    is_repeated: bool = False
    progress: DenoiseProgress = field(default_factory=DenoiseProgress)
    is_cancelled: bool = False
    failed_step: FairingStep | None = None
    failure: FairingError | MemoryError | None = None

    @property
    def is_denoise(self) -> bool:
        """Whether this runs `denoise`, not the paper's method."""
        return isinstance(self.settings, DenoiseSettings)

    @property
    def has_result(self) -> bool:
        """Whether there is at least one shape."""
        return bool(self.steps) or self.denoised is not None or self.kept is not None

    @property
    def is_changed(self) -> bool:
        """Whether there is a result that differs from the input."""
        return bool(self.steps) or (self.denoised is not None and self.denoised.is_changed)

    @property
    def is_over(self) -> bool:
        """Whether the job has ended."""
        is_last = bool(self.steps) and self.steps[-1].stop_reason is not None
        has_all = self.denoised is not None or self.kept is not None
        return is_last or has_all or self.failure is not None

    @property
    def shapes(self) -> list[NDArray[np.float32]]:
        """Positions (n, 3) after each step, or at each strength."""
        if self.denoised is not None:
            return list(self.denoised.shapes)
        return [step.positions for step in self.steps]

    @property
    def knots(self) -> tuple[float, ...]:
        """Strength, or number of the step, of every shape."""
        if self.denoised is not None:
            return tuple(self.denoised.strengths.tolist())
        return tuple(range(1, len(self.steps) + 1))

    @property
    def shown(self) -> int:
        """Index of the shape that is the result: the last step, or the strength asked for."""
        return len(self.steps) - 1 if self.denoised is None else self.denoised.chosen

    @property
    def positions(self) -> NDArray[np.float32]:
        """Positions (n, 3) of the result."""
        return self.shapes[self.shown] if self.kept is None else self.kept

    @property
    def measures(self) -> list[SurfaceMeasures]:
        """Measures of the input and of every shape."""
        if self.denoised is not None:
            return [self.denoised.initial, *self.denoised.measures]
        of_steps = [SurfaceMeasures(s.curvature_energy, s.area, s.volume) for s in self.steps]
        return [self.steps[0].initial, *of_steps]

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on defects of the mesh and on the result, one line each."""
        if self.denoised is not None:
            return self.denoised.notes
        return self.steps[-1].notes if self.steps else ()

    @property
    def stop_reason(self) -> str | None:
        """Why the steps ended, as in `FairingStep`; None while they run, and for `denoise`."""
        last = self.failed_step or (self.steps[-1] if self.steps else None)
        return None if last is None else last.stop_reason

    @property
    def seconds(self) -> float:
        """Time that the finished part took, in seconds."""
        return sum(self.step_seconds)

    @property
    def error(self) -> str | None:
        """`failure` as a line for the user."""
        if isinstance(self.failure, MemoryError):
            return (
                f"not enough memory for {len(self.triangles)} triangles; "
                "fair a decimated copy, or parts"
            )
        return None if self.failure is None else str(self.failure)

    def take_result(self, other: Solve) -> None:
        """Take over the result of a solve with the same input."""
        self.denoised, self.steps = other.denoised, list(other.steps)
        self.step_seconds, self.is_repeated = list(other.step_seconds), True

    def has_input_of(self, other: Solve) -> bool:
        """Whether another solve has the same input and settings, hence the same result."""
        if self.settings != other.settings or (self.weights is None) != (other.weights is None):
            return False
        pairs = [(self.vertices, other.vertices), (self.triangles, other.triangles)]
        if self.weights is not None:
            pairs.append((self.weights, other.weights))
        return all(np.array_equal(mine, others) for mine, others in pairs)

    def run(self) -> Iterator[Solve]:
        """Run the algorithm; yield this object after every step, for `denoise` once.

        If the mesh cannot be solved, the run ends without an exception: `failure` says why. A step
        that has not converged is not kept.

        Raises
        ------
        RunCancelledError
            `is_cancelled` was set while `denoise` was running.
        """
        try:
            yield from self._denoise() if self.is_denoise else self._fair()
        except (FairingError, MemoryError) as error:
            self.failure = error
        finally:
            if self.preparations is not None:
                self.preparations.release()

    def _preparation(self) -> PreparedMesh | None:
        if self.prepared is not None or self.preparations is None:
            return self.prepared
        is_fair = isinstance(self.settings, FairingSettings)
        tolerance = self.settings.quadrature_tolerance if is_fair else DEFAULT_TOLERANCE
        return self.preparations.of(self.vertices, self.triangles, tolerance)

    def _denoise(self) -> Iterator[Solve]:
        started = time.perf_counter()
        result = denoise(
            self.vertices,
            self.triangles,
            self.settings,
            weights=self.weights,
            prepared=self._preparation(),
            plan=self.plan,
            progress=self.note_progress,
        )
        self.step_seconds = [time.perf_counter() - started]
        # Rounding to what Blender keeps must not exceed the limit, either.
        limit = self.settings.max_deviation
        shapes = [limited(each.astype(np.float32), self.vertices, limit) for each in result.shapes]
        self.denoised = replace(result, shapes=np.stack(shapes))
        yield self

    def _fair(self) -> Iterator[Solve]:
        started = time.perf_counter()
        for step in fair_steps(
            self.vertices,
            self.triangles,
            self.settings,
            weights=self.weights,
            prepared=self._preparation(),
        ):
            self.step_seconds.append(time.perf_counter() - started)
            density = step.density.astype(np.float32)
            positions = limited(
                step.positions.astype(np.float32), self.vertices, self.settings.max_deviation
            )
            step = replace(step, positions=positions, density=density)
            if not step.solve.converged:
                self.failed_step = step
                raise SolverError(
                    f"step {step.index} did not converge: residual {step.solve.residual:.3g} "
                    f"after {step.solve.iterations} iterations; choose a smaller radius or tau"
                )
            self.steps.append(step)
            yield self
            started = time.perf_counter()

    def keep_result_only(self) -> None:
        """Keep only the `positions` of a finished solve, and free all other arrays."""
        if self.has_result and self.is_over:
            self.kept = self.positions
            self.denoised, self.prepared, self.plan = None, None, None
            self.steps.clear()

    def note_progress(self, progress: DenoiseProgress) -> None:
        """Note the progress of `denoise`.

        Raises
        ------
        RunCancelledError
            The run was cancelled.
        """
        self.progress = progress
        if self.on_fraction_done is not None:
            self.on_fraction_done(progress.fraction_done)
        if self.is_cancelled:
            raise RunCancelledError


def run_solves(solves: Iterable[Solve]) -> Iterator[Solve]:
    """Run one solve after the other; yield the current one after every step.

    A mesh that cannot be solved does not stop the others; a solve that has ended is left out.
    """
    for solve in solves:
        if solve.is_over:
            continue
        try:
            yield from solve.run()
        except RunCancelledError:
            return
