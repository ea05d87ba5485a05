"""The triangle mesh: connectivity, normals, density, cuts into a manifold, checks of input."""
