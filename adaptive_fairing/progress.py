"""How far a run is, on standard error."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .core import FairingStep

try:
    from tqdm import tqdm
except ImportError:  # Blender's own Python has no tqdm
    tqdm = None


@contextmanager
def step_progress(total: int, *, enabled: bool) -> Iterator[Callable[[FairingStep], None]]:
    """Show a progress bar while the body runs, or a line per step where tqdm is missing.

    Parameters
    ----------
    total
        Number of steps, if no stopping rule ends the run earlier.
    enabled
        Whether to show anything.

    Yields
    ------
    callable
        To be called after every step.
    """
    if not enabled:
        yield lambda step: None
    elif tqdm is None:
        yield lambda step: _show_line(step, total)
    else:
        options = {"desc": "fairing", "unit": "step", "leave": False, "mininterval": 0}
        with tqdm(total=total, file=sys.stderr, **options) as bar:

            def advance(step: FairingStep) -> None:
                bar.set_postfix_str(f"{step.solve.iterations} CG iterations", refresh=False)
                bar.update()

            yield advance


def _show_line(step: FairingStep, total: int) -> None:
    line = f"fairing: step {step.index} of {total}, {step.solve.iterations} CG iterations"
    sys.stderr.write(line + "\n")
    sys.stderr.flush()
