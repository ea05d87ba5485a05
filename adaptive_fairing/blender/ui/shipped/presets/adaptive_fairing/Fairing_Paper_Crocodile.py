"""The paper's values for figure 4.2."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.algorithm = "FAIR"
settings.scheme = "TIMESTEP"
settings.use_tau = True
settings.tau = 0.0016
settings.steps = 4
settings.density = "EDGE"
settings.density_passes = 3
