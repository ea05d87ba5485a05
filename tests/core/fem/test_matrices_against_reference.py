"""M and L of all three schemes against whole-mesh subdivision (``support.reference``).

Errors are in units of the largest entry, and in the Frobenius norm relative to the matrix.
"""

from functools import lru_cache

import numpy as np
import pytest
from support import meshes
from support.reference import BruteForceSpace

from adaptive_fairing.core import LoopSpace, TriangleTopology, mesh_density

TIGHT, TIGHT_BOUND = 1e-6, 2e-5
DEFAULT, DEFAULT_BOUND = 1e-3, 1e-3
# Long thin triangles in a corner of the outline, with 8 and more neighbours: a little worse.
DEFAULT_BOUNDS = {"open, irregular, seed 0": 1.5e-3, "open, irregular, seed 1": 1.5e-3}

MESHES = {
    "tetrahedron": meshes.tetrahedron(),
    "octahedron": meshes.octahedron(),
    "icosahedron": meshes.icosahedron(),
    "valences 3 to 10": meshes.random_closed(1),
    "valences 3 to 10, fewer faces": meshes.random_closed(
        1, coarse=meshes.split_1_to_4(*meshes.octahedron())
    ),
    "open, regular": meshes.flat_hexagon(2),
    "open, irregular and flat": meshes.irregular_disc(4),
    "open, irregular and bumpy": meshes.bumpy_disc(4),
    "cylinder": meshes.open_cylinder(8, 2),
    "single triangle": meshes.single_triangle(),
}
THOROUGH_MESHES = {
    "pole of valence 44": meshes.bipyramid(44),
    **{f"valences 3 to 10, seed {seed}": meshes.random_closed(seed) for seed in (2, 3, 4)},
    **{f"open, irregular, seed {seed}": meshes.bumpy_disc(seed) for seed in (0, 1, 2)},
}
CASES = [pytest.param(name, id=name) for name in MESHES] + [
    pytest.param(name, id=name, marks=pytest.mark.thorough) for name in THOROUGH_MESHES
]


TAU = 0.016


@lru_cache
def field_values(name, field):
    """Control values (n,): of the paper's D, or of something rougher than any density."""
    vertices, faces = (MESHES | THOROUGH_MESHES)[name]
    if field == "density":
        return mesh_density(TriangleTopology(faces, len(vertices)), vertices)
    return np.random.default_rng(0).uniform(0.5, 2.0, len(vertices))


@lru_cache
def reference_space(name):
    return BruteForceSpace((MESHES | THOROUGH_MESHES)[name][1])


@lru_cache
def reference_matrix(name, matrix, field=None):
    """Matrix by brute force, computed once for all tolerances."""
    vertices, _ = (MESHES | THOROUGH_MESHES)[name]
    values = None if field is None else field_values(name, field)
    return getattr(reference_space(name), matrix)(vertices, values)


def assert_close(matrix, expected, bound):
    difference = matrix.toarray() - expected
    assert np.abs(difference).max() <= bound * np.abs(expected).max()
    assert np.linalg.norm(difference) <= bound * np.linalg.norm(expected)


def assert_all_schemes_close(name, field, tolerance, bound):
    """Matrices of (3.4) and (3.9) with T = tau D, and those of the uniform timestep."""
    vertices, faces = (MESHES | THOROUGH_MESHES)[name]
    space = LoopSpace(TriangleTopology(faces, len(vertices)), tolerance)
    values = TAU * field_values(name, field)

    plain_mass = reference_matrix(name, "mass_matrix")
    uniform = np.full(len(vertices), TAU)
    assert_close(space.mass_matrix(vertices), plain_mass, bound)
    assert_close(space.mass_matrix(vertices, timestep=uniform), plain_mass / TAU, bound)
    mass = reference_matrix(name, "mass_matrix", field) / TAU
    assert_close(space.mass_matrix(vertices, timestep=values), mass, bound)

    plain_stiffness = reference_matrix(name, "stiffness_matrix")
    assert_close(space.stiffness_matrix(vertices), plain_stiffness, bound)
    stiffness = reference_matrix(name, "stiffness_matrix", field) * TAU
    assert_close(space.stiffness_matrix(vertices, diffusivity=values), stiffness, bound)


@pytest.mark.parametrize("name", CASES)
def test_mass_and_stiffness_matrix_are_right_to_1e_3(name):
    bound = DEFAULT_BOUNDS.get(name, DEFAULT_BOUND)
    assert_all_schemes_close(name, "density", DEFAULT, bound)


@pytest.mark.parametrize("name", CASES)
def test_mass_and_stiffness_matrix_of_tight_quadrature_are_right_to_2e_5(name):
    assert_all_schemes_close(name, "density", TIGHT, TIGHT_BOUND)


@pytest.mark.parametrize("name", ["valences 3 to 10, fewer faces", "cylinder"])
def test_mass_and_stiffness_matrix_of_rough_fields_are_right_to_2e_5(name):
    assert_all_schemes_close(name, "rough", TIGHT, TIGHT_BOUND)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize(
    "name", ["tetrahedron", "octahedron", "icosahedron", "valences 3 to 10, fewer faces"]
)
def test_every_tolerance_bounds_the_error_of_mass_and_stiffness_matrix(name, tolerance):
    assert_all_schemes_close(name, "density", tolerance, tolerance)


def test_the_meshes_have_the_valences_that_they_promise():
    vertices, faces = MESHES["valences 3 to 10"]
    assert set(meshes.valences(faces, len(vertices))) >= set(range(3, 11)) - {8}
    vertices, faces = meshes.random_closed(2)
    assert set(meshes.valences(faces, len(vertices))) == set(range(3, 11))
    faces_around = [
        np.bincount(faces.ravel())[meshes.boundary_vertices(faces)]
        for _, faces in (meshes.bumpy_disc(4), meshes.bumpy_disc(2))
    ]
    assert set(np.concatenate(faces_around)) >= {1, 2, 3, 4, 5, 6}


@pytest.mark.parametrize(
    "n_segments", [pytest.param(44), pytest.param(200, marks=pytest.mark.thorough)]
)
def test_mass_and_stiffness_matrix_at_a_pole_of_high_valence(n_segments):
    """The reference is good to about 5e-4 here: the mesh is too large for more levels."""
    vertices, faces = meshes.latlong_sphere(n_segments, 3)
    space = LoopSpace(TriangleTopology(faces, len(vertices)))
    reference = BruteForceSpace(faces, (3, 4, 5))
    assert_close(space.mass_matrix(vertices), reference.mass_matrix(vertices), 1e-3)
    assert_close(space.stiffness_matrix(vertices), reference.stiffness_matrix(vertices), 1e-3)


def test_vertex_met_twice_by_one_patch_counts_twice():
    """On a torus of 7 vertices each patch of 12 control points meets some of them twice.

    The torus grid of 7 x 7 covers it seven times and has no such patch; folding its matrices
    together must give seven times the small ones, to rounding.
    """
    vertices, faces = meshes.seven_vertex_torus()
    cover_faces = meshes.torus(7, 7)[1]
    x, y = np.divmod(np.arange(49), 7)
    below = (x + 2 * y) % 7  # the lattice map that takes the one connectivity to the other
    fold = np.eye(7)[below]
    field = np.random.default_rng(1).uniform(0.5, 2.0, 7)
    small = LoopSpace(TriangleTopology(faces, 7))
    cover = LoopSpace(TriangleTopology(cover_faces, 49))
    for name, argument in (
        ("mass_matrix", "timestep"),
        ("stiffness_matrix", "diffusivity"),
    ):
        folded = fold.T @ getattr(cover, name)(vertices[below], **{argument: field[below]}) @ fold
        single = getattr(small, name)(vertices, **{argument: field}).toarray()
        np.testing.assert_allclose(folded / 7, single, atol=1e-13 * np.abs(single).max())
