"""Noise of a mesh: its level, its correlation, and shape that looks like noise."""
