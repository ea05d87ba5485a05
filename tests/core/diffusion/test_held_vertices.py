"""Boundaries, weights, loose vertices and components: what moves, what stays, bit by bit."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import FairingSettings, LoopSpace, TriangleTopology, fair, mesh_density
from adaptive_fairing.core.loop.basis import evaluate_basis
from adaptive_fairing.core.loop.patches import PatchSet

METHODS = ("uniform", "adaptive_timestep", "adaptive_tensor")


@pytest.fixture(params=METHODS)
def method(request):
    return request.param


# Open boundaries ---------------------------------------------------------------------------------


def test_fixed_boundary_stays_bit_by_bit_and_the_rest_moves(method):
    vertices, faces = meshes.bumpy_disc(0)
    vertices = vertices * 0.7 + 0.1  # not exact in binary
    result = fair(vertices, faces, FairingSettings(method=method, steps=2))
    border = meshes.boundary_vertices(faces)
    inner = np.setdiff1d(np.arange(len(vertices)), border)
    np.testing.assert_array_equal(result.positions[border], vertices[border])
    assert (np.linalg.norm(result.positions[inner] - vertices[inner], axis=1) > 0).all()


def test_fixed_boundary_solves_the_equations_of_the_other_vertices():
    vertices, faces = meshes.bumpy_disc(0)
    settings = FairingSettings(tau=0.05, steps=1, normalize=False, cg_tolerance=1e-12)
    result = fair(vertices, faces, settings)
    topology = TriangleTopology(faces, len(vertices))
    space = LoopSpace(topology)
    mass = space.mass_matrix(vertices, timestep=0.05 * mesh_density(topology, vertices)).toarray()
    matrix = mass + space.stiffness_matrix(vertices).toarray()
    held = meshes.boundary_vertices(faces)
    free = np.setdiff1d(np.arange(len(vertices)), held)
    right_side = (mass @ vertices)[free] - matrix[np.ix_(free, held)] @ vertices[held]
    expected = np.linalg.solve(matrix[np.ix_(free, free)], right_side)
    np.testing.assert_allclose(result.positions[free], expected, atol=1e-10)


def test_free_boundary_moves_by_the_natural_condition():
    vertices, faces = meshes.bumpy_disc(0)
    settings = FairingSettings(
        tau=0.05, steps=1, boundary="free", normalize=False, cg_tolerance=1e-12
    )
    result = fair(vertices, faces, settings)
    topology = TriangleTopology(faces, len(vertices))
    space = LoopSpace(topology)
    mass = space.mass_matrix(vertices, timestep=0.05 * mesh_density(topology, vertices)).toarray()
    matrix = mass + space.stiffness_matrix(vertices).toarray()
    expected = np.linalg.solve(matrix, mass @ vertices)
    np.testing.assert_allclose(result.positions, expected, atol=1e-10)
    border = meshes.boundary_vertices(faces)
    assert (np.linalg.norm(result.positions[border] - vertices[border], axis=1) > 0).all()


@pytest.mark.parametrize("boundary", ["fixed", "free"])
def test_flat_disc_stays_flat(method, boundary):
    vertices, faces = meshes.irregular_disc(0)
    settings = FairingSettings(method=method, boundary=boundary, steps=3)
    result = fair(vertices, faces, settings)
    np.testing.assert_allclose(result.positions[:, 2], 0, atol=1e-14)


def test_flat_disc_with_fixed_boundary_moves_only_where_the_diffusivity_varies(method):
    """(2.6): without curvature all that is left is the gradient of D, of the tensor scheme."""
    vertices, faces = meshes.irregular_disc(0)
    settings = FairingSettings(method=method, tau=0.05, quadrature_tolerance=1e-6)
    move = np.abs(fair(vertices, faces, settings).positions - vertices).max()
    if method == "adaptive_tensor":
        assert move > 1e-3
    else:
        assert move < 1e-6


def test_flat_disc_with_fixed_boundary_keeps_its_area():
    vertices, faces = meshes.irregular_disc(0)
    result = fair(vertices, faces, FairingSettings(steps=3, quadrature_tolerance=1e-5))
    for step in result.steps:
        assert step.area == pytest.approx(result.initial.area, rel=1e-5)


def test_free_disc_shrinks_like_the_heat_flow_of_its_outline():
    """With the natural condition area decreases in every step, and the disc stays round."""
    vertices, faces = meshes.flat_hexagon(6)
    settings = FairingSettings(method="uniform", tau=0.05, boundary="free", steps=4)
    result = fair(vertices, faces, settings)
    areas = [result.initial.area] + [step.area for step in result.steps]
    assert (np.diff(areas) < 0).all()
    np.testing.assert_allclose(
        result.positions.mean(axis=0), vertices.mean(axis=0), atol=1e-6 * np.ptp(vertices)
    )


@pytest.mark.parametrize(
    "mesh",
    [meshes.bumpy_disc(0), meshes.open_cylinder(5, 1), meshes.single_triangle()],
    ids=["irregular", "cylinder", "single triangle"],
)
def test_boundary_curve_is_the_cubic_b_spline_of_the_boundary_vertices(mesh):
    vertices, faces = mesh
    along = np.linspace(0.1, 0.9, 5)
    blending = (
        np.stack(
            [
                (1 - along) ** 3,
                3 * along**3 - 6 * along**2 + 4,
                -3 * along**3 + 3 * along**2 + 3 * along + 1,
                along**3,
            ],
            axis=1,
        )
        / 6
    )
    directed = {(int(face[k]), int(face[(k + 1) % 3])) for face in faces for k in range(3)}
    following = {a: b for a, b in directed if (b, a) not in directed}
    preceding = {b: a for a, b in following.items()}
    patch_set = PatchSet(TriangleTopology(faces, len(vertices)))
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    seen = 0
    for segment in patch_set.segments:
        for control_points in segment.control_points.T:
            for k in range(3):
                start, end = control_points[k], control_points[(k + 1) % 3]
                if following.get(start) != end:
                    continue
                seen += 1
                points = corners[k] + along[:, None] * (corners[(k + 1) % 3] - corners[k])
                values = evaluate_basis(patch_set.classes[segment.class_index], points)[0]
                curve = values @ vertices[control_points]
                stencil = [preceding[start], start, end, following[end]]
                np.testing.assert_allclose(curve, blending @ vertices[stencil], atol=1e-13)
    assert seen == len(following)


# Weights -----------------------------------------------------------------------------------------


def test_weight_zero_holds_vertices_bit_by_bit(method):
    vertices, faces = meshes.noisy_ball(2, 0.03)
    weights = (vertices[:, 2] > 0.2).astype(float)
    result = fair(vertices, faces, FairingSettings(method=method), weights=weights)
    held = weights == 0
    np.testing.assert_array_equal(result.positions[held], vertices[held])
    assert (np.linalg.norm(result.positions[~held] - vertices[~held], axis=1) > 0).all()


def test_weight_one_everywhere_is_no_weight(method):
    vertices, faces = meshes.noisy_ball(2, 0.03)
    settings = FairingSettings(method=method, steps=2)
    np.testing.assert_array_equal(
        fair(vertices, faces, settings, weights=np.ones(len(vertices))).positions,
        fair(vertices, faces, settings).positions,
    )


def test_all_weights_zero_change_nothing(method):
    vertices, faces = meshes.noisy_ball(2, 0.03)
    weights = np.zeros(len(vertices))
    result = fair(vertices, faces, FairingSettings(method=method), weights=weights)
    np.testing.assert_array_equal(result.positions, vertices)


def test_smaller_weights_move_less(method):
    vertices, faces = meshes.noisy_ball(2, 0.03)
    settings = FairingSettings(method=method, steps=1)
    moves = []
    for weight in (0.1, 0.4, 1.0):
        weights = np.full(len(vertices), weight)
        move = fair(vertices, faces, settings, weights=weights).positions - vertices
        moves.append(np.sqrt(np.mean(move**2)))
    assert moves[0] < 0.7 * moves[1] < 0.7 * 0.9 * moves[2]


def test_uniform_weight_is_a_smaller_tau(method):
    """The weight is a share of the local timestep or diffusivity."""
    vertices, faces = meshes.noisy_ball(2, 0.03)
    weighted = fair(
        vertices,
        faces,
        FairingSettings(method=method, tau=0.04, steps=2, cg_tolerance=1e-12),
        weights=np.full(len(vertices), 0.25),
    )
    smaller = fair(
        vertices, faces, FairingSettings(method=method, tau=0.01, steps=2, cg_tolerance=1e-12)
    )
    np.testing.assert_allclose(weighted.positions, smaller.positions, atol=1e-9)


def test_fractional_region_moves_less_than_the_full_one(method):
    vertices, faces = meshes.noisy_ball(3, 0.03)
    weights = np.where(vertices[:, 0] > 0, 1.0, 0.05)
    result = fair(vertices, faces, FairingSettings(method=method, steps=1), weights=weights)
    move = np.linalg.norm(result.positions - vertices, axis=1)
    assert move[vertices[:, 0] < -0.3].mean() < 0.6 * move[vertices[:, 0] > 0.3].mean()


# Loose vertices and components -------------------------------------------------------------------


def test_loose_vertices_stay_bit_by_bit_and_out_of_the_frame(method):
    """However far away they are: the frame is that of the surface."""
    vertices, faces = meshes.noisy_ball(2, 0.03)
    settings = FairingSettings(method=method, steps=2)
    alone = fair(vertices, faces, settings)
    loose = np.array([(1e3, 0.1, -7.7), (0.3, 0.3, 0.3)])
    padded = np.vstack([loose[:1], vertices, loose[1:]])
    result = fair(padded, faces + 1, settings)
    np.testing.assert_array_equal(result.positions[[0, -1]], loose)
    np.testing.assert_allclose(result.positions[1:-1], alone.positions, atol=1e-12)
    np.testing.assert_array_equal(result.steps[0].density[[0, -1]], 0)


def test_components_are_faired_as_if_alone(method):
    """But for the common frame, which ``normalize=False`` takes away."""
    parts = [meshes.noisy_ball(2, 0.03), meshes.bumpy_disc(0), meshes.random_closed(1)]
    parts = [(vertices + 3 * k, faces) for k, (vertices, faces) in enumerate(parts)]
    settings = FairingSettings(
        method=method, tau=0.02, steps=2, normalize=False, cg_tolerance=1e-13
    )
    together = fair(*meshes.merged(*parts), settings)
    alone = [fair(*part, settings) for part in parts]
    np.testing.assert_allclose(
        together.positions, np.vstack([result.positions for result in alone]), atol=1e-9
    )
    for step, *single in zip(together.steps, *(result.steps for result in alone), strict=True):
        np.testing.assert_allclose(
            step.density, np.concatenate([other.density for other in single]), rtol=1e-7
        )
        assert step.area == pytest.approx(sum(other.area for other in single), rel=1e-8)
