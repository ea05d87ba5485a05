"""Numeric core of Adaptive Fairing: numpy and scipy only, never bpy.

Geometric diffusion of surface meshes in the finite element space of Loop's subdivision basis,
after C. Bajaj and G. Xu, *Adaptive Fairing of Surface Meshes by Geometric Diffusion*.
"""

from .denoise.plan import AutoEstimate, AutoPlan
from .diffusion.steps import fair, fair_steps
from .errors import FairingError, InputError, SettingsError, SolverError, TopologyError
from .fem.differential_geometry import SurfaceMeasures
from .fem.loop_space import LoopSpace
from .fem.memory_estimate import MemoryNeededError
from .linalg.conjugate_gradients import SolveReport
from .mesh.density import mesh_density
from .mesh.topology import TriangleTopology
from .problem.prepared_mesh import PreparedMesh
from .results import FairingResult, FairingStep
from .settings import FairingSettings
from .surface.limit_surface import LimitSurface

__all__ = [
    "AutoEstimate",
    "AutoPlan",
    "FairingError",
    "FairingResult",
    "FairingSettings",
    "FairingStep",
    "InputError",
    "LimitSurface",
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
