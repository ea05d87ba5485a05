"""Numeric core of Adaptive Fairing: numpy and scipy only, never bpy.

Two algorithms work in the finite element space of Loop's subdivision basis. `denoise` estimates the
noise of a mesh and removes it. `fair` is geometric diffusion after C. Bajaj and G. Xu, *Adaptive
Fairing of Surface Meshes by Geometric Diffusion*.
"""

from .denoising.denoise import denoise
from .denoising.plan import DenoisePlan
from .denoising.progress import DenoiseProgress
from .denoising.result import DenoiseResult
from .denoising.settings import DenoiseSettings
from .diffusion.result import FairingResult, FairingStep
from .diffusion.settings import DENSITIES, SCHEMES, FairingSettings
from .diffusion.steps import fair, fair_steps
from .diffusion.values import fair_values
from .errors import FairingError, InputError, SettingsError, SolverError, TopologyError
from .fem.differential_geometry import SurfaceMeasures
from .fem.loop_space import LoopSpace
from .fem.memory_estimate import MemoryNeededError
from .linalg.conjugate_gradients import SolveReport
from .mesh.density import mesh_density
from .mesh.topology import TriangleTopology
from .problem.prepared_mesh import PreparedMesh
from .surface.limit_surface import LimitSurface

__all__ = [
    "DENSITIES",
    "SCHEMES",
    "DenoisePlan",
    "DenoiseProgress",
    "DenoiseResult",
    "DenoiseSettings",
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
    "denoise",
    "fair",
    "fair_steps",
    "fair_values",
    "mesh_density",
]
