"""Smooth over several edges everywhere."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.method = "adaptive_timestep"
settings.tau = 0.04
settings.steps = 6
settings.density = "area"
settings.density_passes = 3
