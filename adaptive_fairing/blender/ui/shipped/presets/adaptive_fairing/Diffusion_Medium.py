"""The best single setting for the paper's schemes."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.method = "adaptive_timestep"
settings.tau = 0.0107
settings.steps = 4
settings.density = "area"
settings.density_passes = 3
