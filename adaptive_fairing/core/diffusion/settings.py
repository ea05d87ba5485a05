"""Settings of the paper's diffusion, checked when they are made."""

from __future__ import annotations

from dataclasses import dataclass, fields

from ..mesh.density import DENSITY_KINDS
from ..problem.prepared_mesh import DEFAULT_TOLERANCE
from ..problem.setting_checks import (
    BOUNDARIES,
    require_choice,
    require_flag,
    require_integer,
    require_number,
)

METHODS = ("adaptive_timestep", "adaptive_tensor", "uniform")

# Beyond these the entries of the linear system overflow or underflow in double precision.
TAU_RANGE = (1e-30, 1e30)


@dataclass(frozen=True)
class FairingSettings:
    """What to solve, how far and how exactly.

    Attributes
    ----------
    method : str
        "adaptive_timestep" T = τ D and "adaptive_tensor" with diffusivity τ D follow the mesh
        density; "uniform" has one timestep τ everywhere.
    tau : float
        τ > 0 of the paper, per step, in the [-3, 3]³ frame; within `TAU_RANGE`.
    steps : int
        Number of semi-implicit steps, at least 1; a stopping rule may end the run earlier.
    density : str
        d_i as mean "edge_length" to the neighbours or as "area" of the triangles around.
    density_passes : int
        Smoothing passes (3.6) over d_i.
    boundary : str
        "fixed": boundary vertices stay exactly where they are; "free": natural condition.
    stop_curvature : float, optional
        ε2 of (3.11): stop once H(t)/H(0) ≤ ε2.
    stop_rate : float, optional
        ε1 of (3.10): stop once |dH/dt|, by differences over one step τ, is ≤ ε1.
    cg_tolerance : float
        Relative residual at which a solve counts as converged.
    cg_max_iterations : int
    quadrature_tolerance : float
        Bound for the error of matrix entries relative to the largest, 1e-6 to 1.
    normalize : bool
        Scale the mesh into [-3, 3]³ for the solve, as the paper does; otherwise τ is in the
        mesh's own units.

    Raises
    ------
    SettingsError
        If a value makes no sense; the message names the field.

    Source: sections 3.2 to 3.4 of the paper.
    """

    method: str = "adaptive_timestep"
    tau: float = 0.016
    steps: int = 4
    density: str = "edge_length"
    density_passes: int = 3
    boundary: str = "fixed"
    stop_curvature: float | None = None
    stop_rate: float | None = None
    cg_tolerance: float = 1e-6
    cg_max_iterations: int = 5000
    quadrature_tolerance: float = DEFAULT_TOLERANCE
    normalize: bool = True

    def __post_init__(self) -> None:
        require_choice(self, "method", METHODS)
        require_choice(self, "density", DENSITY_KINDS)
        require_choice(self, "boundary", BOUNDARIES)
        require_integer(self, "steps", least=1)
        require_integer(self, "density_passes", least=0)
        require_integer(self, "cg_max_iterations", least=1)
        require_number(self, "tau", above=TAU_RANGE[0], below=TAU_RANGE[1])
        require_number(self, "cg_tolerance", above=0, below=1)
        require_number(self, "quadrature_tolerance", above=0, below=1)
        for name in ("stop_curvature", "stop_rate"):
            if getattr(self, name) is not None:
                require_number(self, name, above=0)
        require_flag(self, "normalize")

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of all settings, in order."""
        return tuple(field.name for field in fields(cls))
