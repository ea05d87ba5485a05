"""Results of `fair` and `fair_steps`."""

from __future__ import annotations

from dataclasses import dataclass

from ..fem.differential_geometry import SurfaceMeasures, energy_ratio
from ..linalg.conjugate_gradients import SolveReport
from ..runtime.arrays import FloatArray
from .settings import FairingSettings


@dataclass(frozen=True)
class FairingStep:
    """The surface after one semi-implicit step.

    Attributes
    ----------
    index : int
        1 for the first step.
    tau : float
        τ of the run: that of the settings, or the one that their radius asks for.
    time : float
        index · τ.
    positions : (n, 3)
        In the units of the input; vertices that are held have their input coordinates bit by bit.
    density : (n,)
        Smoothed d_i that this step used, in the solver's frame; 0 at loose vertices.  If weights of
        0 hold most of the mesh, the values there are those of the input.
    curvature_energy, area, volume : float
        Measures of the limit surface of `positions`, see `SurfaceMeasures`.  If weights of 0 hold
        most of the mesh, they cover only the part around the moving vertices, which is all that is
        solved on.  That part is open, so its volume is NaN.
    solve : SolveReport
    initial : SurfaceMeasures
        Measures of the surface before the first step.
    stop_reason : str or None
        None while the run goes on; otherwise "steps" (all done), "curvature" (3.11), "rate"
        (3.10), or "not_converged" (the linear solve of this step missed its tolerance).
    notes : tuple of str
        Defects of the input and how it was made solvable, one line each; and a warning if a part
        has begun to collapse.
    """

    index: int
    tau: float
    time: float
    positions: FloatArray
    density: FloatArray
    curvature_energy: float
    area: float
    volume: float
    solve: SolveReport
    initial: SurfaceMeasures
    stop_reason: str | None = None
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
    def positions(self) -> FloatArray:
        """Positions after the last step, (n, 3)."""
        return self.steps[-1].positions

    @property
    def notes(self) -> tuple[str, ...]:
        """Defects of the input and how it was made solvable, one line each."""
        return self.steps[-1].notes
