"""The paper's values for figure 4.1."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.method = "adaptive_timestep"
settings.tau = 0.025
settings.steps = 3
settings.density = "edge_length"
settings.density_passes = 3
