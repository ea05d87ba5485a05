"""Finite elements in the Loop basis: mass and stiffness matrices, surface integrals."""
