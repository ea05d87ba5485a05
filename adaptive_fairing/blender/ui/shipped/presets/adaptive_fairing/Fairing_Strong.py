"""Smooth over more than one edge everywhere."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.algorithm = "FAIR"
settings.scheme = "TIMESTEP"
settings.use_tau = False
settings.radius = 1.1
settings.steps = 6
settings.density = "AREA"
settings.density_passes = 3
