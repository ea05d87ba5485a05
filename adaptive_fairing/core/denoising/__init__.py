"""Denoising without a parameter: estimate the noise, mix filters for the least risk."""
