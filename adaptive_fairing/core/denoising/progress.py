"""How far a run of `denoise` has come."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

# About what a phase takes of the processor time, measured on 80 000 triangles.
NOISE, ROUNDS, MIXTURE, MEASURES = 0.16, (0.04, 0.11, 0.13, 0.18, 0.27), 0.07, 0.05


class DenoiseProgress(NamedTuple):
    """News of a run.

    Attributes
    ----------
    phase : str
        What is being done: "noise" is measured, the mesh is filtered ("filter"), the filters are
        mixed ("mix"), the result is measured ("measure").
    number, total : int
        Which round of filters this is, counted from 1, and of how many; 0 in the other phases.
    done : float
        Part of the work that is done, 0 to 1.
    until : float
        Part that will be done at the end of the phase.
    """

    phase: str = "noise"
    number: int = 0
    total: int = 0
    done: float = 0.0
    until: float = 0.0


class ProgressReport:
    """Tells a caller, if there is one, where a run is.

    Parameters
    ----------
    tell : callable, optional
        Called with `DenoiseProgress`; may raise to end the run.
    has_plan : bool
        Whether the noise is known beforehand.
    """

    def __init__(self, tell: Callable[[DenoiseProgress], None] | None, *, has_plan: bool) -> None:
        self._tell = tell
        rounds = [("filter", number, fraction) for number, fraction in enumerate(ROUNDS, start=1)]
        phases = [("noise", 0, 0.0 if has_plan else NOISE), *rounds, ("mix", 0, MIXTURE)]
        phases.append(("measure", 0, MEASURES))
        total = sum(fraction for *_, fraction in phases)
        self._news: dict[tuple[str, int], DenoiseProgress] = {}
        done = 0.0
        for phase, number, fraction in phases:
            until = done + fraction / total
            n_rounds = len(ROUNDS) if number else 0
            self._news[phase, number] = DenoiseProgress(phase, number, n_rounds, done, until)
            done = until
        self._now = DenoiseProgress()

    def begin(self, phase: str, number: int = 0) -> None:
        """Enter a phase, and a round of the filters."""
        self._now = self._news[phase, number]
        self.again()

    def again(self) -> None:
        """Tell once more: the caller may want to end the run."""
        if self._tell is not None:
            self._tell(self._now)

    def finish(self) -> None:
        """Tell that all is done."""
        self._now = DenoiseProgress("measure", done=1.0, until=1.0)
        self.again()
