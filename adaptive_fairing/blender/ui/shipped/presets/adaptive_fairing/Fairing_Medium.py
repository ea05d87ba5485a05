"""The best single setting for the paper's schemes."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.algorithm = "FAIR"
settings.scheme = "TIMESTEP"
settings.use_tau = False
settings.radius = 0.47
settings.steps = 4
settings.density = "AREA"
settings.density_passes = 3
