"""The paper's values for figure 4.2."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.method = "adaptive_timestep"
settings.tau = 0.0016
settings.steps = 4
settings.density = "edge_length"
settings.density_passes = 3
