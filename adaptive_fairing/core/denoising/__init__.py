"""Automatic denoising: estimates of the noise, and mixtures of filters with the least risk."""
