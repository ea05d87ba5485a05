"""A run as plain numbers: no bpy, so that it may work in a thread beside Blender's window."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...core import FairingError, FairingSettings, FairingStep, PreparedMesh, fair_steps
from ...core.denoise.plan import AutoPlan


@dataclass
class FairingTask:
    """One mesh to fair, and what has become of it so far.

    Attributes
    ----------
    name, library
        Of the object, and the file it is linked from. Objects themselves must not be kept: undo
        and deletion invalidate them.
    vertices, triangles, weights
        Input of `fair_steps`.
    settings
        For the solver.
    steps
        Finished steps, their arrays as float32, which is what Blender keeps. Of "auto" all
        strengths or none.
    share
        How much of the solve is done, up to 1.
    is_cancelled
        Set to end a run of "auto", whose strengths come all at the end, in the middle.
    error
        Why the run ended early: one line.
    seconds
        Time it took.
    """

    name: str
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    weights: NDArray[np.float64] | None
    settings: FairingSettings
    library: str | None = None
    steps: list[FairingStep] = field(default_factory=list)
    share: float = 0.0
    is_cancelled: bool = False
    error: str | None = None
    seconds: float = 0.0

    @property
    def is_auto(self) -> bool:
        """Whether there are strengths in place of steps."""
        return self.settings.method == "auto"

    def note_progress(self, share: float) -> None:
        """Take note of the share of the solve that is done.

        Raises
        ------
        RunCancelledError
            The run is no longer wanted.
        """
        self.share = share
        if self.is_auto and self.is_cancelled:
            raise RunCancelledError


class RunCancelledError(Exception):
    """Nobody waits for the result any more."""


def run_tasks(
    tasks: Iterable[FairingTask],
    prepared: PreparedMesh | None = None,
    plan: AutoPlan | None = None,
) -> Iterator[FairingTask]:
    """Fair one mesh after the other; yield the task at hand after every step, of "auto" once.

    A mesh that cannot be faired does not keep the others from it: its task says why. All tasks
    must have the triangles that were prepared, if any were; `plan` is as for `fair_steps`.
    """
    for task in tasks:
        if task.error is not None:
            continue
        try:
            yield from _run(task, prepared, plan)
        except RunCancelledError:
            return
        except FairingError as error:
            task.error = str(error)
        except MemoryError:
            task.error = (
                f"not enough memory for {len(task.triangles)} triangles; "
                "fair a decimated copy, or parts"
            )


def _run(
    task: FairingTask, prepared: PreparedMesh | None, plan: AutoPlan | None
) -> Iterator[FairingTask]:
    started = time.perf_counter()
    steps = fair_steps(
        task.vertices,
        task.triangles,
        task.settings,
        weights=task.weights,
        prepared=prepared,
        plan=plan,
        progress=task.note_progress,
    )
    # The chosen strength is in the middle: some of the strengths alone would be no result.
    for batch in [list(steps)] if task.is_auto else ([step] for step in steps):
        task.seconds = time.perf_counter() - started
        for step in batch:
            if not step.solve.converged:
                task.error = not_converged(step)
                return
        task.steps += [_for_blender(step) for step in batch]
        yield task


def _for_blender(step: FairingStep) -> FairingStep:
    positions, density = step.positions.astype(np.float32), step.density.astype(np.float32)
    return replace(step, positions=positions, density=density)


def not_converged(step: FairingStep) -> str:
    """Say that the solver gave up a step, and what to do."""
    advice = "choose a smaller tau" if step.auto is None else "repair or remesh thin triangles"
    return (
        f"step {step.index} did not converge: residual {step.solve.residual:.3g} after "
        f"{step.solve.iterations} iterations; {advice}"
    )
