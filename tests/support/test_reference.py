"""The brute-force reference itself, held against exact values and against its own next level."""

import numpy as np
import pytest

from support import meshes
from support.reference import (
    BruteForceSpace,
    fine_barycentric,
    limit_matrix,
    linear_mass_matrix,
    linear_stiffness_matrix,
    subdivision_matrix,
)

# How far levels 3, 4, 5 may be from levels 4, 5, 6, in units of the largest entry.
SELF_CONSISTENT = [
    ("tetrahedron", meshes.tetrahedron(), 1e-6),
    ("octahedron", meshes.octahedron(), 1e-6),
    ("icosahedron", meshes.icosahedron(), 1e-6),
    ("random closed", meshes.random_closed(1), 1e-5),
    ("irregular open", meshes.bumpy_disc(0), 2e-5),
    ("cylinder", meshes.open_cylinder(6, 2), 1e-6),
    ("single triangle", meshes.single_triangle(), 1e-6),
]


def relative_difference(a, b):
    return np.abs(a - b).max() / np.abs(b).max()


@pytest.mark.parametrize(
    ("mesh", "bound"), [pytest.param(*case[1:], id=case[0]) for case in SELF_CONSISTENT]
)
def test_extrapolation_has_converged(mesh, bound):
    vertices, faces = mesh
    field = np.random.default_rng(0).uniform(0.5, 2.0, len(vertices))
    coarse, fine = BruteForceSpace(faces, (3, 4, 5)), BruteForceSpace(faces)
    for matrix in ("mass_matrix", "stiffness_matrix"):
        pair = [getattr(space, matrix)(vertices, field) for space in (coarse, fine)]
        assert relative_difference(*pair) < bound, matrix


def test_subdivision_and_limit_rows_sum_to_one_and_commute():
    """The limit position does not depend on the level at which the limit mask is applied."""
    for vertices, faces in (meshes.random_closed(1), meshes.bumpy_disc(0)):
        n_vertices = len(vertices)
        subdivision, fine_faces = subdivision_matrix(faces, n_vertices)
        limit, fine_limit = (
            limit_matrix(faces, n_vertices),
            limit_matrix(fine_faces, subdivision.shape[0]),
        )
        np.testing.assert_allclose(subdivision.sum(axis=1), 1, atol=1e-14)
        np.testing.assert_allclose(limit.sum(axis=1), 1, atol=1e-14)
        np.testing.assert_allclose(
            (fine_limit @ subdivision)[:n_vertices].toarray(), limit.toarray(), atol=1e-14
        )


def test_fine_barycentric_coordinates_are_those_of_midpoint_subdivision():
    vertices, faces = meshes.bumpy_disc(0)
    fine_vertices, fine_faces = vertices, faces
    for _ in range(2):
        fine_vertices, fine_faces = meshes.split_1_to_4(fine_vertices, fine_faces)
    corners = vertices[faces][np.arange(len(fine_faces)) % len(faces)]
    placed = np.einsum("fcb,fbd->fcd", fine_barycentric(len(faces), 2), corners)
    fine_sorted = np.sort(fine_vertices[fine_faces].reshape(-1, 3), axis=0)
    np.testing.assert_allclose(np.sort(placed.reshape(-1, 3), axis=0), fine_sorted, atol=1e-14)


def test_flat_regular_patch_has_the_entries_of_the_box_spline():
    """On equilateral triangles: integrals known from the box spline's own refinement relation.

    The mass entries of the hexagonal lattice sum to the area of one vertex, the stiffness entries
    to 0 with second moment -2 area (so that linear and quadratic functions are treated exactly).
    """
    vertices, faces = meshes.flat_hexagon(5)
    centre = np.argmin(np.linalg.norm(vertices - vertices.mean(axis=0), axis=1))
    space = BruteForceSpace(faces, (2, 3, 4))
    mass, stiffness = space.mass_matrix(vertices)[centre], space.stiffness_matrix(vertices)[centre]
    offset = vertices - vertices[centre]
    area = np.sqrt(0.75)  # of the two triangles that belong to a vertex
    assert mass.sum() == pytest.approx(area, rel=1e-6)
    assert stiffness.sum() == pytest.approx(0, abs=1e-6)
    np.testing.assert_allclose(
        np.einsum("i,id,ie->de", stiffness, offset, offset)[:2, :2],
        -2 * area * np.eye(2),
        atol=1e-5,
    )


def test_linear_elements_are_exact_on_a_single_triangle():
    vertices, faces = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0)]), np.array([(0, 1, 2)])
    factor = np.array([1.0, 2.0, 4.0])
    np.testing.assert_allclose(
        linear_mass_matrix(vertices, faces).toarray() * 24, [[2, 1, 1], [1, 2, 1], [1, 1, 2]]
    )
    # For instance, the integral of x_a^2 (x_a + 2 x_b + 4 x_c) is (6 + 2 * 2 + 4 * 2) / 120.
    np.testing.assert_allclose(
        linear_mass_matrix(vertices, faces, factor).toarray() * 120,
        [[18, 10, 12], [10, 22, 13], [12, 13, 30]],
    )
    np.testing.assert_allclose(
        linear_stiffness_matrix(vertices, faces).toarray() * 2,
        [[2, -1, -1], [-1, 1, 0], [-1, 0, 1]],
        atol=1e-15,
    )


def test_area_and_volume_of_a_finely_meshed_sphere():
    vertices, faces = meshes.icosphere(3)
    space = BruteForceSpace(faces, (0, 1, 2))
    radius = np.linalg.norm(limit_matrix(faces, len(vertices)) @ vertices, axis=1).mean()
    assert space.area(vertices / radius) == pytest.approx(4 * np.pi, rel=2e-4)
    assert space.volume(vertices / radius) == pytest.approx(4 / 3 * np.pi, rel=2e-4)
