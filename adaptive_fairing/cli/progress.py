"""Progress of a run on standard error."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

from ..batch.summary import FAILED
from .messages import say, write_line

if TYPE_CHECKING:
    from ..blender.jobs.solve import Solve
try:
    from tqdm import tqdm
except ImportError:  # Blender's own Python has no tqdm
    tqdm = None


@contextmanager
def step_progress(total: int, *, enabled: bool) -> Iterator[Callable[[Solve], None]]:
    """Show a progress bar while the body runs; without tqdm, a line for each step.

    Parameters
    ----------
    total
        Number of steps, if no stopping rule ends the run earlier.
    enabled
        Whether to show anything.

    Yields
    ------
    callable
        To be called after every step, with the report of its solve.
    """
    if not enabled:
        yield lambda solve: None
    elif tqdm is None:
        yield lambda solve: _show_line(solve, total)
    else:
        options = {"desc": "fairing", "unit": "step", "leave": False, "mininterval": 0}
        with tqdm(total=total, file=sys.stderr, **options) as bar:

            def advance(solve: Solve) -> None:
                iterations = solve.steps[-1].solve.iterations
                bar.set_postfix_str(f"{iterations} CG iterations", refresh=False)
                bar.update()

            yield advance


@contextmanager
def part_progress(*, enabled: bool) -> Iterator[Callable[[float], None]]:
    """Show a progress bar for `denoise`, which ends with one result, if tqdm is there.

    The bar appears at the first call, because `denoise` may follow other work.

    Parameters
    ----------
    enabled
        Whether to show anything.

    Yields
    ------
    callable
        To be called with the fraction that is done, from 0 to 1.
    """
    if not enabled or tqdm is None:
        yield lambda part: None
        return
    options = {
        "desc": "denoising",
        "leave": False,
        "mininterval": 0,
        "miniters": 1e-6,
        "bar_format": "{l_bar}{bar}| {elapsed}<{remaining}",
    }
    with ExitStack() as stack:
        bar = None

        def advance(part: float) -> None:
            nonlocal bar
            if bar is None:
                bar = stack.enter_context(tqdm(total=1.0, file=sys.stderr, **options))
            # Solves run side by side, so their messages may arrive in another order.
            bar.update(max(part - bar.n, 0))

        yield advance


class MeshProgress:
    """Progress of a batch: a bar over all its meshes, and a line for each that failed.

    Parameters
    ----------
    total
        Number of meshes.
    show_bar
        Whether to show the bar.
    farm_lines
        Write a line to standard output for every mesh, in the form that Flamenco counts as
        progress of its task.
    """

    def __init__(self, total: int, *, show_bar: bool, farm_lines: bool) -> None:
        self._farm_lines = farm_lines
        self._started = time.perf_counter()
        self._bar = None
        if show_bar and tqdm is not None:
            self._bar = tqdm(total=total, file=sys.stderr, desc="fairing", unit="mesh")

    def finished(self, entry: Mapping[str, Any]) -> None:
        """Count a mesh; its entry is that of `batch.summary.mesh_entry`."""
        if entry["status"] == FAILED:
            with self._beside_bar():
                say(f"{entry['output']}: {entry['error']}")
        if self._bar is not None:
            self._bar.update()
        if self._farm_lines:
            elapsed = time.perf_counter() - self._started
            line = f"Time: {elapsed:.1f} s | {entry['output']}: {entry['status']}"
            write_line(line, sys.stdout)

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.close()

    def _beside_bar(self) -> AbstractContextManager[None]:
        return nullcontext() if self._bar is None else self._bar.external_write_mode(sys.stderr)


def _show_line(solve: Solve, total: int) -> None:
    step = solve.steps[-1]
    line = f"fairing: step {step.index} of {total}, {step.solve.iterations} CG iterations"
    sys.stderr.write(line + "\n")
    sys.stderr.flush()
