"""The paper's claims, measured, in a module each; `python -m research.claims` runs them."""
