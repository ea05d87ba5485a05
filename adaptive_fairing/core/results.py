"""What a run of `fair_steps` yields, and what `fair` returns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .denoise.plan import AutoEstimate
from .fem.differential_geometry import SurfaceMeasures
from .linalg.conjugate_gradients import SolveReport
from .runtime.arrays import FloatArray
from .settings import FairingSettings


@dataclass(frozen=True)
class FairingStep:
    """The surface after one semi-implicit step, or one strength of "auto".

    Attributes
    ----------
    index : int
        1 for the first step.
    time : float
        index · τ; nan for "auto", which has no time.
    positions : (n, 3)
        In the units of the input; vertices that are held have their input coordinates bit by bit.
    density : (n,)
        d_i after smoothing, in the [-3, 3]³ frame, as this step used it; 0 at loose vertices.
    curvature_energy, area, volume : float
        Measures of the limit surface of `positions`, see `SurfaceMeasures`.
    solve : SolveReport
    initial : SurfaceMeasures
        Measures of the surface before the first step.
    stop_reason : str or None
        None while the run goes on; otherwise "steps" (all done), "curvature" (3.11), "rate"
        (3.10), or "not_converged" (the linear solve of this step missed its tolerance).
    auto : AutoEstimate or None
        What "auto" found and chose.
    notes : tuple of str
        What is wrong with the input and how it was made solvable, one line each; and whether
        something has begun to collapse.
    """

    index: int
    time: float
    positions: FloatArray
    density: FloatArray
    curvature_energy: float
    area: float
    volume: float
    solve: SolveReport
    initial: SurfaceMeasures
    stop_reason: str | None = None
    auto: AutoEstimate | None = None
    notes: tuple[str, ...] = ()

    @property
    def curvature_ratio(self) -> float:
        """H(t) of the paper: curvature energy relative to that of the input surface."""
        return energy_ratio(self.curvature_energy, self.initial.curvature_energy)


@dataclass(frozen=True)
class FairingResult:
    """A finished run.

    Attributes
    ----------
    steps : tuple of FairingStep
    stop_reason : str
        As in the last step.
    settings : FairingSettings
    initial : SurfaceMeasures
        Measures of the input surface.
    """

    steps: tuple[FairingStep, ...]
    stop_reason: str
    settings: FairingSettings
    initial: SurfaceMeasures

    @property
    def chosen(self) -> FairingStep:
        """The last step; of "auto" the one with the strength that was asked for."""
        return chosen_step(self.steps)

    @property
    def positions(self) -> FloatArray:
        """Final positions, (n, 3): those of the chosen step."""
        return self.chosen.positions

    @property
    def noise(self) -> float | None:
        """Noise that "auto" found, in local edge lengths: see `AutoEstimate`."""
        return None if self.chosen.auto is None else self.chosen.auto.noise

    @property
    def radius(self) -> float | None:
        """Smoothing radius that "auto" chose, in local edge lengths: see `AutoEstimate`."""
        return None if self.chosen.auto is None else self.chosen.auto.radius

    @property
    def notes(self) -> tuple[str, ...]:
        """What is wrong with the input and how it was made solvable, one line each."""
        return self.steps[-1].notes


def chosen_step(steps: Sequence[FairingStep]) -> FairingStep:
    """Take the step that is the result of a run, see `FairingResult.chosen`."""
    chosen = [step for step in steps if step.auto is not None and step.auto.is_chosen]
    return (chosen or steps)[-1]


def energy_ratio(energy: float, initial: float) -> float:
    """H(t)/H(0); a surface that was flat from the start has nothing left to lose."""
    return energy / initial if initial > 0 else 0.0
