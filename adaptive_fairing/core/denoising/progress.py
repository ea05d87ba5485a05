"""Progress of a run of `denoise`."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

# About what a phase takes of the processor time, measured on 80 000 triangles.
NOISE_SHARE, MIXTURE_SHARE, MEASURES_SHARE = 0.16, 0.07, 0.05
SHARE_OF_ROUND = (0.04, 0.11, 0.13, 0.18, 0.27)


class DenoiseProgress(NamedTuple):
    """Progress of a run.

    Attributes
    ----------
    phase : str
        "noise" (measuring the noise), "filter", "mix" (mixing the filters) or "measure" (measuring
        the result).
    number, total : int
        Number of the filter round, counted from 1, and of all rounds; 0 in the other phases.
    fraction_done : float
        Fraction of the work that is done, 0 to 1.
    fraction_at_end : float
        Fraction of the work that will be done when the phase ends.
    """

    phase: str = "noise"
    number: int = 0
    total: int = 0
    fraction_done: float = 0.0
    fraction_at_end: float = 0.0


class ProgressReport:
    """Reports the progress of a run to a caller, if there is one.

    Parameters
    ----------
    tell : callable, optional
        Called with `DenoiseProgress`; may raise to end the run.
    has_plan : bool
        Whether a plan is given, so that the noise is already known.
    """

    def __init__(self, tell: Callable[[DenoiseProgress], None] | None, *, has_plan: bool) -> None:
        self._tell = tell
        rounds = [("filter", number, share) for number, share in enumerate(SHARE_OF_ROUND, start=1)]
        phases = [("noise", 0, 0.0 if has_plan else NOISE_SHARE), *rounds]
        phases += [("mix", 0, MIXTURE_SHARE), ("measure", 0, MEASURES_SHARE)]
        total = sum(share for *_, share in phases)
        self._news: dict[tuple[str, int], DenoiseProgress] = {}
        done = 0.0
        for phase, number, share in phases:
            until = done + share / total
            n_rounds = len(SHARE_OF_ROUND) if number else 0
            self._news[phase, number] = DenoiseProgress(phase, number, n_rounds, done, until)
            done = until
        self._now = DenoiseProgress()

    def begin(self, phase: str, number: int = 0) -> None:
        """Enter a phase, and a round of the filters; what is done again does not go back."""
        news = self._news[phase, number]
        done = max(news.fraction_done, self._now.fraction_done)
        at_end = max(news.fraction_at_end, done)
        self._now = news._replace(fraction_done=done, fraction_at_end=at_end)
        self.again()

    def again(self) -> None:
        """Report again, because the caller may want to end the run."""
        if self._tell is not None:
            self._tell(self._now)

    def finish(self) -> None:
        """Report the end of the run."""
        self._now = DenoiseProgress("measure", fraction_done=1.0, fraction_at_end=1.0)
        self.again()
