"""Identities that M and L of the Loop basis obey on every mesh, whatever the quadrature."""

import numpy as np
import pytest
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components
from support import meshes
from support.reference import BruteForceSpace

from adaptive_fairing.core import LoopSpace, TriangleTopology, mesh_density

CASES = [
    pytest.param(mesh, id=name)
    for name, mesh in {
        "tetrahedron": meshes.tetrahedron(),
        "icosahedron": meshes.icosahedron(),
        "torus of 3 x 3": meshes.torus(3, 3),
        "seven-vertex torus": meshes.seven_vertex_torus(),
        "valences 3 to 10": meshes.random_closed(1),
        "pole of valence 44": meshes.bipyramid(44),
        "graded sphere": meshes.graded_sphere(2),
        "open, irregular": meshes.bumpy_disc(0),
        "single triangle": meshes.single_triangle(),
        "two components": meshes.merged(meshes.octahedron(), meshes.open_cylinder(5, 2)),
    }.items()
]


def space_of(mesh, tolerance=1e-3):
    vertices, faces = mesh
    return LoopSpace(TriangleTopology(faces, len(vertices)), tolerance)


def matrices_of(mesh, tolerance=1e-3):
    """M, M with a timestep field, L, L with a diffusivity; dense."""
    vertices = mesh[0]
    space = space_of(mesh, tolerance)
    field = mesh_density(space.topology, vertices)
    return [
        matrix.toarray()
        for matrix in (
            space.mass_matrix(vertices),
            space.mass_matrix(vertices, timestep=field),
            space.stiffness_matrix(vertices),
            space.stiffness_matrix(vertices, diffusivity=field),
        )
    ]


def assert_same_matrices(mesh, other, factors=(1, 1, 1, 1), order=slice(None), atol=1e-12):
    """``other``'s matrices, rows and columns in ``order``, are ``factors`` times those of mesh."""
    for matrix, changed, factor in zip(matrices_of(mesh), matrices_of(other), factors, strict=True):
        np.testing.assert_allclose(
            changed[order][:, order], factor * matrix, atol=atol * factor * np.abs(matrix).max()
        )


@pytest.mark.parametrize("mesh", CASES)
def test_matrices_are_exactly_symmetric(mesh):
    for matrix in matrices_of(mesh):
        np.testing.assert_array_equal(matrix, matrix.T)


@pytest.mark.parametrize("mesh", CASES)
def test_mass_matrix_is_positive_definite_and_stiffness_semidefinite(mesh):
    """The kernel of L has one dimension per component: the constants."""
    adjacency = np.eye(len(mesh[0]))
    adjacency[tuple(meshes.edges_of(mesh[1]).T)] = 1
    n_components, _ = connected_components(adjacency, directed=False)
    mass, mass_timestep, stiffness, stiffness_diffusivity = matrices_of(mesh)
    for matrix in (mass, mass_timestep):
        assert linalg.eigvalsh(matrix).min() > 0
    for matrix in (stiffness, stiffness_diffusivity):
        eigenvalues = linalg.eigvalsh(matrix)
        zero = 1e-12 * eigenvalues.max()
        assert eigenvalues.min() > -zero
        assert np.count_nonzero(eigenvalues < zero) == n_components


@pytest.mark.parametrize("mesh", CASES)
def test_constants_do_not_diffuse(mesh):
    for stiffness in matrices_of(mesh)[2:]:
        np.testing.assert_allclose(
            stiffness.sum(axis=1), 0, atol=1e-12 * np.abs(stiffness).max() * len(stiffness) ** 0.5
        )


@pytest.mark.parametrize("mesh", CASES)
def test_sum_of_mass_matrix_is_the_limit_area(mesh):
    vertices = mesh[0]
    space = space_of(mesh)
    assert space.mass_matrix(vertices).sum() == pytest.approx(
        space.measures(vertices).area, rel=1e-12
    )


@pytest.mark.parametrize(
    "mesh",
    [meshes.icosahedron(), meshes.random_closed(1), meshes.bumpy_disc(0)],
    ids=["icosahedron", "valences 3 to 10", "open"],
)
def test_area_and_volume_are_those_of_the_subdivided_surface(mesh):
    vertices, faces = mesh
    reference = BruteForceSpace(faces, (2, 3, 4))
    for tolerance, bound in ((1e-3, 1e-3), (1e-5, 2e-5)):
        space = space_of(mesh, tolerance)
        measures = space.measures(vertices)
        assert measures.area == pytest.approx(reference.area(vertices), rel=bound)
        if space.topology.is_closed:
            assert measures.volume == pytest.approx(reference.volume(vertices), rel=bound)
        else:
            assert np.isnan(measures.volume)


@pytest.mark.parametrize("mesh", CASES)
def test_constant_fields_are_factors(mesh):
    vertices = mesh[0]
    space = space_of(mesh)
    constant = np.full(len(vertices), 0.25)
    for changed, factor, plain in (
        (space.mass_matrix(vertices, timestep=constant), 4, space.mass_matrix(vertices)),
        (
            space.stiffness_matrix(vertices, diffusivity=constant),
            0.25,
            space.stiffness_matrix(vertices),
        ),
    ):
        np.testing.assert_allclose(
            changed.toarray(), factor * plain.toarray(), atol=1e-13 * factor * abs(plain).max()
        )


def test_stiffness_of_the_positions_is_the_gradient_of_area():
    """d Area = (grad x, grad v): the identity behind mean curvature motion, by differences."""
    vertices, faces = meshes.random_closed(1)
    space = space_of((vertices, faces), 1e-5)
    direction = np.random.default_rng(4).normal(size=vertices.shape)
    step = 1e-5
    difference = (
        space.measures(vertices + step * direction).area
        - space.measures(vertices - step * direction).area
    ) / (2 * step)
    assert np.sum((space.stiffness_matrix(vertices) @ vertices) * direction) == pytest.approx(
        difference, rel=1e-7
    )


def test_linear_functions_are_harmonic_on_a_flat_mesh():
    """L x = 0 in the rows of vertices whose basis functions vanish on the boundary."""
    vertices, faces = meshes.irregular_disc(0, n_rings=5)
    residual = space_of((vertices, faces)).stiffness_matrix(vertices) @ vertices
    distance = np.full(len(vertices), 3)
    distance[meshes.boundary_vertices(faces)] = 0
    start, end = meshes.edges_of(faces).T
    for _ in range(3):
        np.minimum.at(distance, start, distance[end] + 1)
        np.minimum.at(distance, end, distance[start] + 1)
    inner = distance >= 2
    assert inner.any()
    assert np.abs(residual[inner]).max() < 1e-3 * np.abs(residual[~inner]).max()
    tight = space_of((vertices, faces), 1e-6).stiffness_matrix(vertices) @ vertices
    assert np.abs(tight[inner]).max() < 1e-6 * np.abs(tight[~inner]).max()


# Invariance --------------------------------------------------------------------------------------

INVARIANCE_CASES = [
    pytest.param(meshes.random_closed(1), id="closed"),
    pytest.param(meshes.bumpy_disc(0), id="open"),
]


@pytest.mark.parametrize("mesh", INVARIANCE_CASES)
def test_scaling(mesh):
    """M scales as the area, L not at all; here d is a length, so T^-1 and c bring their own."""
    vertices, faces = mesh
    assert_same_matrices(mesh, (8 * vertices, faces), factors=(64, 8, 1, 8))


@pytest.mark.parametrize("mesh", INVARIANCE_CASES)
def test_translation_and_rotation(mesh):
    vertices, faces = mesh
    rotation = linalg.expm(np.array([(0, -0.4, 0.9), (0.4, 0, -1.3), (-0.9, 1.3, 0)]))
    assert_same_matrices(mesh, (vertices @ rotation.T + (5, -3, 2), faces))


@pytest.mark.parametrize("mesh", INVARIANCE_CASES)
def test_vertex_renumbering(mesh):
    vertices, faces = mesh
    order = np.random.default_rng(2).permutation(len(vertices))
    renumbered = np.empty_like(vertices)
    renumbered[order] = vertices
    assert_same_matrices(mesh, (renumbered, order[faces]), order=order)


@pytest.mark.parametrize("mesh", INVARIANCE_CASES)
def test_face_rotation(mesh):
    """The corner at which a face starts makes no difference."""
    vertices, faces = mesh
    shifts = np.random.default_rng(3).integers(0, 3, len(faces))
    rotated = np.take_along_axis(faces, (np.arange(3) + shifts[:, None]) % 3, axis=1)
    assert_same_matrices(mesh, (vertices, rotated))


@pytest.mark.parametrize("mesh", INVARIANCE_CASES)
def test_face_order_and_orientation(mesh):
    vertices, faces = mesh
    shuffled = np.random.default_rng(5).permutation(faces)
    assert_same_matrices(mesh, (vertices, shuffled))
    assert_same_matrices(mesh, (vertices, faces[:, ::-1]))


def test_regularity_does_not_show_in_an_isolated_component():
    """Each component has the block that it has alone."""
    closed, opened = meshes.random_closed(1), meshes.bumpy_disc(0)
    together = matrices_of(meshes.merged(closed, opened))
    n_closed = len(closed[0])
    for whole, first, second in zip(
        together, matrices_of(closed), matrices_of(opened), strict=True
    ):
        np.testing.assert_allclose(
            whole, linalg.block_diag(first, second), atol=1e-13 * np.abs(whole).max()
        )
        assert not whole[:n_closed, n_closed:].any()


def test_large_mesh_is_the_sum_of_its_parts():
    """Large enough that assembly cuts it into pieces of work: 40960 triangles, shuffled.

    Two spheres side by side, numbered at random, against one of them alone.
    """
    vertices, faces = meshes.icosphere(5)
    generator = np.random.default_rng(6)
    vertices = vertices + 0.003 * generator.normal(size=vertices.shape)
    pair, pair_faces = meshes.merged((vertices, faces), (vertices, faces))
    order = generator.permutation(len(pair))
    scrambled = np.empty_like(pair)
    scrambled[order] = pair
    large = space_of((scrambled, generator.permutation(order[pair_faces])))
    small = space_of((vertices, faces))
    for name, argument in (("mass_matrix", "timestep"), ("stiffness_matrix", "diffusivity")):
        field = generator.uniform(1, 2, len(vertices))
        scrambled_field = np.empty(len(pair))
        scrambled_field[order] = np.tile(field, 2)
        whole = getattr(large, name)(scrambled, **{argument: scrambled_field})[order][:, order]
        single = getattr(small, name)(vertices, **{argument: field})
        bound = 1e-12 * abs(single).max()
        assert abs(whole - sparse.block_diag([single, single])).max() < bound
    measures, half = large.measures(scrambled), small.measures(vertices)
    assert measures.area == pytest.approx(2 * half.area, rel=1e-12)
    assert measures.volume == pytest.approx(2 * half.volume, rel=1e-12)
    assert measures.curvature_energy == pytest.approx(2 * half.curvature_energy, rel=1e-12)


def test_loose_vertices_have_empty_rows():
    vertices, faces = meshes.octahedron()
    loose = (np.vstack([vertices, [(9.0, 9, 9)]]), faces)
    space = space_of(loose)
    for matrix in (space.mass_matrix(loose[0]), space.stiffness_matrix(loose[0])):
        assert matrix.shape == (7, 7)
        assert not matrix.toarray()[6].any()


def test_positions_and_fields_are_not_changed():
    vertices, faces = meshes.random_closed(1)
    field = np.linspace(1, 2, len(vertices))
    before = vertices.copy(), faces.copy(), field.copy()
    for array in (vertices, faces, field):
        array.setflags(write=False)
    space = space_of((vertices, faces))
    space.mass_matrix(vertices, timestep=field)
    space.stiffness_matrix(vertices, diffusivity=field)
    space.measures(vertices)
    for array, copy in zip((vertices, faces, field), before, strict=True):
        np.testing.assert_array_equal(array, copy)
