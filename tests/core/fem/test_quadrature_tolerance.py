"""`quadrature_tolerance` bounds the entries of M and L on meshes that no constant was fitted on."""

import numpy as np
import pytest
from support import meshes
from support.reference import BruteForceSpace

from adaptive_fairing.core import LoopSpace, TriangleTopology, mesh_density
from adaptive_fairing.core.loop.quadrature import COARSE_TRIANGLES

# Subdivided so often, and extrapolated, the reference is exact to this, in units of the largest
# entry: that is how far it is from the tightest quadrature, which shares nothing with it.
LEVELS = (3, 4, 5)
REFERENCE_ERROR = 1e-5


def seeds(count, n_fast):
    """The first few seeds for every run; the others say the same of more meshes."""
    return [
        seed if seed < n_fast else pytest.param(seed, marks=pytest.mark.thorough)
        for seed in range(count)
    ]


def random_mesh(seed):
    """A convex hull of 12 to 100 vertices."""
    n_vertices = int(np.random.default_rng(seed).integers(12, 101))
    return meshes.random_hull(seed, n_vertices)


def matrices(space, vertices, density):
    """M and L of the timestep and of the tensor scheme."""
    return [
        space.mass_matrix(vertices),
        space.mass_matrix(vertices, timestep=density),
        space.stiffness_matrix(vertices),
        space.stiffness_matrix(vertices, diffusivity=density),
    ]


def largest_errors(found, expected):
    return [abs(a - b).max() / abs(b).max() for a, b in zip(found, expected, strict=True)]


def mesh_of(vertices, faces):
    topology = TriangleTopology(faces, len(vertices))
    return topology, mesh_density(topology, vertices)


@pytest.mark.parametrize("seed", seeds(20, 6))
def test_entries_are_within_the_tolerance(seed):
    vertices, faces = random_mesh(seed)
    topology, density = mesh_of(vertices, faces)
    reference = matrices(BruteForceSpace(faces, LEVELS), vertices, density)
    for tolerance in (1e-3, 1e-6):
        found = matrices(LoopSpace(topology, tolerance), vertices, density)
        assert max(largest_errors(found, reference)) <= max(tolerance, REFERENCE_ERROR)


@pytest.mark.parametrize("seed", seeds(10, 3))
def test_entries_are_within_the_default_tolerance_where_the_fitted_rule_serves(seed):
    """The exact matrices are tight ones, which the test above compares with the reference."""
    vertices, faces = meshes.random_hull(seed, 300)
    assert len(faces) > COARSE_TRIANGLES
    topology, density = mesh_of(vertices, faces)
    exact = matrices(LoopSpace(topology, 1e-5), vertices, density)
    found = matrices(LoopSpace(topology), vertices, density)
    assert max(largest_errors(found, exact)) <= 1e-3
