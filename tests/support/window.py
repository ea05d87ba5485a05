"""Bounds on what tests see in Blender's own window."""

N_COLOURS_OF_AN_INTERFACE = 100
"""A drawn interface has more; a region that is blank or shows only its background has below 10."""

FLOAT32_STEP = 2.0**-23
"""Step of single precision for coordinates below 1 plus noise."""
