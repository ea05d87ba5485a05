"""Estimate the noise and remove it."""

import bpy

settings = bpy.context.scene.adaptive_fairing

settings.algorithm = "DENOISE"
settings.strength = 1.0
settings.features = "auto"
settings.clean = "keep"
settings.width = 0.0
