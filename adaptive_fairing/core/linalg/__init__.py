"""Sparse symmetric matrices, conjugate gradients, and filters in a Krylov space."""
