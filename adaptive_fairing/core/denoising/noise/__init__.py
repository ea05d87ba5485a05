"""Noise of a mesh: its level, its correlation, and shape that only looks like it."""
