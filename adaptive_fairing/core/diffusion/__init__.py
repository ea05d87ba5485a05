"""The paper's algorithm: geometric diffusion, step by step."""
