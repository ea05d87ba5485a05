"""Take a little noise, the same number of edges everywhere."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.method = "adaptive_timestep"
settings.tau = 0.004
settings.steps = 3
settings.density = "area"
settings.density_passes = 3
