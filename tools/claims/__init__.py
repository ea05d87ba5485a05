"""The paper's claims, measured: one module for each, run with `python -m claims` in tools/."""
