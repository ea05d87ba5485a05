"""How the numerics run: precision of numbers, threads."""
