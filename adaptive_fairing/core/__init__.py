"""Numeric core of Adaptive Fairing: numpy and scipy only, never bpy.

Geometric diffusion of surface meshes in the finite element space of Loop's subdivision basis,
after C. Bajaj and G. Xu, *Adaptive Fairing of Surface Meshes by Geometric Diffusion*.
"""

from .assembly import LoopSpace
from .auto_estimate import AutoEstimate, AutoPlan
from .density import mesh_density
from .errors import FairingError, InputError, SettingsError, SolverError, TopologyError
from .fairing import fair, fair_steps
from .geometry import SurfaceMeasures
from .linear_solver import SolveReport
from .memory import MemoryNeededError
from .prepared import PreparedMesh
from .results import FairingResult, FairingStep
from .settings import FairingSettings
from .topology import TriangleTopology

__all__ = [
    "AutoEstimate",
    "AutoPlan",
    "FairingError",
    "FairingResult",
    "FairingSettings",
    "FairingStep",
    "InputError",
    "LoopSpace",
    "MemoryNeededError",
    "PreparedMesh",
    "SettingsError",
    "SolveReport",
    "SolverError",
    "SurfaceMeasures",
    "TopologyError",
    "TriangleTopology",
    "fair",
    "fair_steps",
    "mesh_density",
]
