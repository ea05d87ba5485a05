"""Settings of the paper's diffusion, checked when they are made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

from ..mesh.density import DENSITY_KINDS
from ..mesh.solver_mesh import Frame
from ..problem.prepared_mesh import DEFAULT_TOLERANCE
from ..problem.setting_checks import (
    BOUNDARIES,
    require_choice,
    require_flag,
    require_frame,
    require_integer,
    require_number,
)

SCHEMES: Mapping[str, str] = MappingProxyType(
    {"timestep": "adaptive_timestep", "tensor": "adaptive_tensor", "uniform": "uniform"}
)
"""The schemes as the command line, Blender and reports name them: word -> `method`."""

DENSITIES: Mapping[str, str] = MappingProxyType({"edge": "edge_length", "area": "area"})
"""The measures of density as they are named in the same places: word -> `density`."""

DEFAULT_RADIUS = 0.5

# The paper takes three; a run with more than so many would hardly end.
MOST_PASSES = 10_000

# Beyond these the entries of the linear system overflow or underflow in double precision.
TAU_RANGE = (1e-30, 1e30)


@dataclass(frozen=True)
class FairingSettings:
    """Method, amount and accuracy of the paper's diffusion.

    Attributes
    ----------
    method : str
        "adaptive_timestep" T = τ D and "adaptive_tensor" with diffusivity τ D follow the mesh
        density; "uniform" has one timestep τ everywhere.
    tau : float, optional
        τ > 0 of the paper, per step, in the solver's frame (see `normalize`); within `TAU_RANGE`.
        None takes the τ that `radius` asks for on the mesh at hand.
    radius : float
        Smoothing radius after all steps where the mesh is of typical density, in local edge
        lengths; counts where `tau` is None. The default was best, or nearly so, on noisy meshes
        of many shapes with either density.
    steps : int
        Number of semi-implicit steps, at least 1; a stopping rule may end the run earlier.
    density : str
        d_i as mean "edge_length" to the neighbours or as "area" of the triangles around.
    density_passes : int
        Smoothing passes (3.6) over d_i.
    boundary : str
        "fixed": boundary vertices stay exactly where they are; "free": natural condition.
    keep_volume : bool
        Move every closed part along its normals after each step, in proportion to the local time,
        so that the volume within its triangles stays. `max_deviation` comes after that.
    max_deviation : float, optional
        No vertex ends a step further than this length, in object units, from its input position.
    stop_curvature : float, optional
        ε2 of (3.11): stop once H(t)/H(0) ≤ ε2.
    stop_rate : float, optional
        ε1 of (3.10): stop once |dH/dt|, by differences over one step τ, is ≤ ε1.
    cg_tolerance : float
        Relative residual at which a solve counts as converged.
    cg_max_iterations : int
    quadrature_tolerance : float
        Bound for the error of matrix entries relative to the largest, 1e-6 to 1.
    normalize : "box", "sphere" or False
        Unit of τ. "box" scales the mesh into [-3, 3]³ for the solve, as the paper does; that box
        changes when the mesh is turned, and one τ with it. "sphere" scales the smallest sphere
        around the mesh to radius 3, so that a turned mesh gives the same result. False leaves τ
        in the mesh's own units. Without `tau` the result does not depend on it.

    Raises
    ------
    SettingsError
        If a value is invalid; the message names the field.

    Source: sections 3.2 to 3.4 of the paper.
    """

    method: str = "adaptive_timestep"
    tau: float | None = None
    radius: float = DEFAULT_RADIUS
    steps: int = 4
    density: str = "edge_length"
    density_passes: int = 3
    boundary: str = "fixed"
    keep_volume: bool = False
    max_deviation: float | None = None
    stop_curvature: float | None = None
    stop_rate: float | None = None
    cg_tolerance: float = 1e-6
    cg_max_iterations: int = 5000
    quadrature_tolerance: float = DEFAULT_TOLERANCE
    normalize: Frame = "box"

    def __post_init__(self) -> None:
        require_choice(self, "method", tuple(SCHEMES.values()))
        require_choice(self, "density", DENSITY_KINDS)
        require_choice(self, "boundary", BOUNDARIES)
        require_integer(self, "steps", least=1)
        require_integer(self, "density_passes", least=0, most=MOST_PASSES)
        require_integer(self, "cg_max_iterations", least=1)
        require_number(self, "radius", above=0)
        if self.tau is not None:
            require_number(self, "tau", above=TAU_RANGE[0], below=TAU_RANGE[1])
        require_number(self, "cg_tolerance", above=0, below=1)
        require_number(self, "quadrature_tolerance", above=0, below=1)
        for name in ("max_deviation", "stop_curvature", "stop_rate"):
            if getattr(self, name) is not None:
                require_number(self, name, above=0)
        require_flag(self, "keep_volume")
        require_frame(self, "normalize")

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of all settings, in order."""
        return tuple(field.name for field in fields(cls))
