"""Remove a little noise, over the same number of edges everywhere."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.algorithm = "FAIR"
settings.scheme = "TIMESTEP"
settings.use_tau = False
settings.radius = 0.25
settings.steps = 3
settings.density = "AREA"
settings.density_passes = 3
