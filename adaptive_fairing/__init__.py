"""Adaptive Fairing: geometric diffusion of surface meshes that follows their density."""
