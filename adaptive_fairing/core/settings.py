"""Settings of a fairing run, checked when they are made."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from .errors import SettingsError
from .mesh.density import DENSITY_KINDS

METHODS = ("adaptive_timestep", "adaptive_tensor", "uniform", "auto")
BOUNDARIES = ("fixed", "free")
FEATURES = ("auto", "sharp", "smooth")

# Beyond these the entries of the linear system overflow or underflow in double precision.
TAU_RANGE = (1e-30, 1e30)


@dataclass(frozen=True)
class FairingSettings:
    """What to solve, how far and how exactly.

    Attributes
    ----------
    method : str
        "adaptive_timestep" T = τ D and "adaptive_tensor" with diffusivity τ D follow the mesh
        density; "uniform" has one timestep τ everywhere.  "auto" estimates the noise and needs
        neither τ nor steps, see the module `auto`.
    tau : float
        τ > 0 of the paper, per step, in the [-3, 3]³ frame; within `TAU_RANGE`.
    steps : int
        Number of semi-implicit steps, at least 1; a stopping rule may end the run earlier.
    density : str
        d_i as mean "edge_length" to the neighbours or as "area" of the triangles around.
    density_passes : int
        Smoothing passes (3.6) over d_i.
    strength : float
        Only for "auto": factor of the estimated noise, above 0 and below 100.
    features : str
        Only for "auto": "sharp" keeps creases wherever it can, "smooth" has no creases to keep,
        "auto" chooses per place.
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
    strength: float = 1.0
    features: str = "auto"
    density: str = "edge_length"
    density_passes: int = 3
    boundary: str = "fixed"
    stop_curvature: float | None = None
    stop_rate: float | None = None
    cg_tolerance: float = 1e-6
    cg_max_iterations: int = 5000
    quadrature_tolerance: float = 1e-3
    normalize: bool = True

    def __post_init__(self) -> None:
        _require_choice(self, "method", METHODS)
        _require_choice(self, "density", DENSITY_KINDS)
        _require_choice(self, "boundary", BOUNDARIES)
        _require_choice(self, "features", FEATURES)
        _require_integer(self, "steps", 1)
        _require_integer(self, "density_passes", 0)
        _require_integer(self, "cg_max_iterations", 1)
        _require_number(self, "tau", above=TAU_RANGE[0], below=TAU_RANGE[1])
        _require_number(self, "strength", above=0, below=100)
        _require_number(self, "cg_tolerance", above=0, below=1)
        _require_number(self, "quadrature_tolerance", above=0, below=1)
        for name in ("stop_curvature", "stop_rate"):
            if getattr(self, name) is not None:
                _require_number(self, name, above=0)
        if not isinstance(self.normalize, bool):
            raise SettingsError(f"normalize must be True or False, not {self.normalize!r}")

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of all settings, in order."""
        return tuple(field.name for field in fields(cls))


def _require_choice(settings: FairingSettings, name: str, choices: tuple[str, ...]) -> None:
    value = getattr(settings, name)
    if value not in choices:
        raise SettingsError(f"{name} must be one of {', '.join(choices)}, not {value!r}")


def _require_integer(settings: FairingSettings, name: str, least: int) -> None:
    value = getattr(settings, name)
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise SettingsError(f"{name} must be a whole number of at least {least}, not {value!r}")


def _require_number(
    settings: FairingSettings, name: str, *, above: float, below: float = math.inf
) -> None:
    value = getattr(settings, name)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not above < value < below:
        bound = f"greater than {above:g}" + (
            f" and less than {below:g}" if below < math.inf else ""
        )
        raise SettingsError(f"{name} must be a number {bound}, not {value!r}")
