"""A run as plain numbers: no bpy, so that it may work in a thread beside Blender's window."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..core import FairingError, FairingSettings, FairingStep, PreparedMesh, fair_steps
from ..core.auto import AutoPlan


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
        Finished steps, their arrays as float32, which is what Blender keeps.
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
    error: str | None = None
    seconds: float = 0.0


def run_tasks(
    tasks: Iterable[FairingTask],
    prepared: PreparedMesh | None = None,
    plan: AutoPlan | None = None,
) -> Iterator[FairingTask]:
    """Fair one mesh after the other; yield the task at hand after every step.

    A mesh that cannot be faired does not keep the others from it: its task says why. All tasks
    must have the triangles that were prepared, if any were; `plan` is as for `fair_steps`.
    """
    for task in tasks:
        if task.error is not None:
            continue
        started = time.perf_counter()
        try:
            steps = fair_steps(
                task.vertices,
                task.triangles,
                task.settings,
                weights=task.weights,
                prepared=prepared,
                plan=plan,
            )
            for step in steps:
                task.seconds = time.perf_counter() - started
                if not step.solve.converged:
                    task.error = (
                        f"step {step.index} did not converge: residual {step.solve.residual:.3g} "
                        f"after {step.solve.iterations} iterations; choose a smaller τ"
                    )
                    break
                task.steps.append(
                    replace(
                        step,
                        positions=step.positions.astype(np.float32),
                        density=step.density.astype(np.float32),
                    )
                )
                yield task
        except FairingError as error:
            task.error = str(error)
        except MemoryError:
            task.error = (
                f"not enough memory for {len(task.triangles)} triangles; "
                "fair a decimated copy, or parts"
            )
