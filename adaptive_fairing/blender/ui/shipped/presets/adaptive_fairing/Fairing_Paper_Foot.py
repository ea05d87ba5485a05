"""The paper's values for figure 4.1."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.algorithm = "FAIR"
settings.scheme = "TIMESTEP"
settings.use_tau = True
settings.tau = 0.025
settings.steps = 3
settings.density = "EDGE"
settings.density_passes = 3
