"""Bad input through the whole solve: refused with names, or a defined and finite result."""

import numpy as np
import pytest
from support.bad_meshes import (
    bow_tie,
    collapsed,
    everything_wrong,
    klein_bottle,
    moebius_strip,
    three_sheets,
    turned,
)
from support.meshes import (
    bipyramid,
    boundary_vertices,
    bumpy_disc,
    flat_hexagon,
    icosphere,
    merged,
    random_closed,
    single_triangle,
    tetrahedron,
)

from adaptive_fairing.core import FairingSettings, InputError, SolverError, fair, fair_steps
from adaptive_fairing.core.fem.differential_geometry import THINNEST_ASPECT, metric_at
from adaptive_fairing.core.mesh.input_checks import LARGEST_COORDINATE, SMALLEST_SIZE
from adaptive_fairing.core.problem.diagnosis import find_problems

SCHEMES = [
    pytest.param(dict(method=method, density=density), id=f"{method}-{density}")
    for method in ("uniform", "adaptive_timestep", "adaptive_tensor")
    for density in ("edge_length", "area")
]
BAD_MESHES = [
    bow_tie,
    collapsed,
    everything_wrong,
    klein_bottle,
    moebius_strip,
    single_triangle,
    tetrahedron,
    three_sheets,
    turned,
]


def run(mesh, **settings):
    """Fair a mesh and check what every result must be: finite, whole, the input untouched."""
    vertices, faces = np.asarray(mesh[0], dtype=float), mesh[1]
    before = vertices.copy(), faces.copy()
    result = fair(vertices, faces, FairingSettings(**{"steps": 2, **settings}))
    np.testing.assert_array_equal(vertices, before[0])
    np.testing.assert_array_equal(faces, before[1])
    assert result.stop_reason == "steps"
    for step in result.steps:
        assert np.isfinite(step.positions).all()
        assert np.isfinite(step.density).all()
        assert np.isfinite([step.area, step.curvature_energy, step.solve.residual]).all()
    return result


# Refused ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "the mesh has no triangles"),
        (np.zeros((3, 3)), np.zeros((0, 3), int), "the mesh has no triangles"),
        (np.zeros((3, 3)), [(0, 1, 1), (2, 2, 2)], "none of the 2 triangles has three different"),
        (np.zeros((3, 2)), [(0, 1, 2)], r"vertices must have shape \(n, 3\), not \(3, 2\)"),
        (np.zeros(9), [(0, 1, 2)], r"vertices must have shape \(n, 3\)"),
        (np.zeros((4, 3)), [(0, 1, 2, 3)], r"faces must have shape \(m, 3\).*triangulate first"),
        (np.zeros((3, 3)), [(0.0, 1.0, 2.0)], "faces must be integers, not float64"),
        (np.zeros((3, 3)), [(0, 1, 2), (0, 1, 3)], "1 triangles use vertices outside 0 … 2.* 1$"),
        (np.zeros((3, 3)), [(0, 1, -1)], "1 triangles use vertices outside 0 … 2"),
    ],
)
def test_what_is_no_mesh_is_refused_at_the_call(vertices, faces, message):
    with pytest.raises(InputError, match=message):
        fair_steps(vertices, faces)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_coordinates_that_are_no_numbers_are_refused_by_name(value):
    vertices, faces = random_closed(seed=1)
    vertices[[3, 17], [0, 2]] = value
    with pytest.raises(InputError, match=r"^2 vertices have coordinates that .* 3, 17;"):
        fair_steps(vertices, faces)
    np.testing.assert_array_equal(find_problems(vertices, faces).not_finite, [3, 17])


def test_coordinates_out_of_any_range_are_refused():
    vertices, faces = random_closed(seed=1)
    vertices[5, 1] = 1.01 * LARGEST_COORDINATE
    with pytest.raises(InputError, match=r"^1 vertices have coordinates beyond 1e\+39: 5; scale"):
        fair_steps(vertices, faces)
    with pytest.raises(InputError, match=r"^the mesh is only .*e-40 across: scale it up"):
        fair_steps(random_closed(seed=1)[0] * 0.1 * SMALLEST_SIZE, faces)


@pytest.mark.parametrize("weight", [-0.1, 1.1, np.nan])
def test_weights_out_of_range_are_refused_by_name(weight):
    vertices, faces = tetrahedron()
    with pytest.raises(InputError, match=r"^1 weights lie outside \[0, 1\]: at vertices 2"):
        fair_steps(vertices, faces, weights=[1, 0, weight, 1])


def test_errors_of_the_solver_name_the_step(monkeypatch):
    from adaptive_fairing.core.diffusion import steps

    calls = []

    def fails_in_the_second_call(*arguments, **options):
        calls.append(options)
        if len(calls) == 2:
            raise SolverError("the linear system is not positive definite: pᵀAp = -1")
        return solve(*arguments, **options)

    solve = steps.conjugate_gradients
    monkeypatch.setattr(steps, "conjugate_gradients", fails_in_the_second_call)
    steps = fair_steps(*random_closed(seed=1))
    assert next(steps).index == 1
    with pytest.raises(SolverError, match=r"^step 2: the linear system is not positive definite"):
        next(steps)


def test_a_solve_that_does_not_converge_ends_the_run_and_says_so():
    hopeless = FairingSettings(cg_max_iterations=1, cg_tolerance=1e-12)
    (step,) = fair_steps(*random_closed(seed=1), hopeless)
    assert step.stop_reason == "not_converged"
    assert not step.solve.converged
    assert step.solve.iterations == 1
    assert step.solve.residual > 1e-12


# Degenerate shapes --------------------------------------------------------------------------------


@pytest.mark.parametrize("mesh", BAD_MESHES)
@pytest.mark.parametrize("settings", SCHEMES[::2])
@pytest.mark.parametrize("boundary", ["fixed", "free"])
def test_bad_meshes_have_a_finite_result_with_every_scheme(mesh, settings, boundary):
    run(mesh(), boundary=boundary, **settings)


@pytest.mark.parametrize("settings", SCHEMES)
def test_all_vertices_in_one_point_stay_there(settings):
    vertices, faces = random_closed(seed=1)
    result = run((0 * vertices + 3, faces), **settings)
    np.testing.assert_array_equal(result.positions, 0 * vertices + 3)
    assert result.notes[0] == "80 triangles have no area, or hardly any: bounded for the solve"


@pytest.mark.parametrize("settings", SCHEMES)
def test_a_piece_in_one_point_stays_there_and_the_other_is_faired_as_without_it(settings):
    vertices, faces = random_closed(seed=1)
    centre = vertices.mean(axis=0)
    both = merged((vertices, faces), (0 * vertices + centre, faces))
    expected = run((vertices, faces), **settings).positions
    result = run(both, **settings).positions
    np.testing.assert_allclose(result[: len(vertices)], expected, atol=1e-6)
    # The solve is as exact as its tolerance, in units of the mesh.
    accuracy = FairingSettings().cg_tolerance * np.ptp(vertices)
    np.testing.assert_allclose(
        result[len(vertices) :], 0 * vertices + centre, rtol=0, atol=accuracy
    )


@pytest.mark.parametrize("settings", SCHEMES)
@pytest.mark.parametrize("factors", [(1, 1, 0), (1, 0, 0), (1, 1e-12, 1e-12), (1, 1e-6, 1)])
def test_flat_thin_and_linear_shapes_stay_in_their_box(settings, factors):
    vertices, faces = random_closed(seed=1)
    vertices = vertices * factors
    result = run((vertices, faces), **settings)
    # A box, not the shape itself: finite elements have no maximum principle.
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    slack = 0.2 * (high - low)
    assert (result.positions >= low - slack).all()
    assert (result.positions <= high + slack).all()


@pytest.mark.parametrize("settings", SCHEMES)
def test_a_collapsed_triangle_does_not_disturb_its_surroundings(settings):
    vertices, faces = icosphere(2)
    squeezed = vertices.copy()
    squeezed[faces[0]] = squeezed[faces[0]].mean(axis=0)
    result = run((squeezed, faces), **settings, tau=0.002)
    expected = run((vertices, faces), **settings, tau=0.002)
    change = np.linalg.norm(result.positions - expected.positions, axis=1)
    edge = np.linalg.norm(vertices[faces[0, 0]] - vertices[faces[0, 1]])
    assert change.max() < edge
    far = np.linalg.norm(vertices - vertices[faces[0, 0]], axis=1) > 6 * edge
    assert far.sum() > 40
    assert change[far].max() < 0.02 * edge


@pytest.mark.parametrize("ratio", [1e-3, 1e-12, 0.0])
def test_the_metric_of_needles_is_bounded(ratio):
    tangents = np.array([[1.0, 0, 0], [1.0, ratio, 0]])[:, :, None]
    metric = metric_at(tangents)
    expected = max(ratio, THINNEST_ASPECT * 2)
    np.testing.assert_allclose(metric.area_element, expected, rtol=1e-4)
    # g⁻¹ √g, which the stiffness is made of, is then bounded by the aspect.
    assert metric.g22 / metric.area_element <= 1 / THINNEST_ASPECT


def test_the_metric_of_a_point_is_positive():
    metric = metric_at(np.zeros((2, 3, 4)))
    assert (metric.area_element > 0).all()


def test_thin_triangles_are_counted_and_located():
    vertices, faces = collapsed()
    result = run((vertices, faces))
    together = np.isin(faces, faces[0]).sum(axis=1) >= 2
    n_thin = int(together.sum())
    assert result.notes == (
        f"{n_thin} triangles have no area, or hardly any: bounded for the solve",
    )
    np.testing.assert_array_equal(find_problems(vertices, faces).thin, np.unique(faces[together]))


@pytest.mark.parametrize("scale", [1e-30, 1e-8, 1.0, 1e8, 1e30])
def test_thin_triangles_are_found_at_any_scale(scale):
    vertices, faces = collapsed()
    expected = find_problems(vertices, faces).thin
    np.testing.assert_array_equal(find_problems(scale * vertices, faces).thin, expected)


def test_surfaces_that_lie_together_unjoined_are_noted():
    vertices, faces = bumpy_disc(seed=1)
    n_border = len(boundary_vertices(faces))
    result = run(merged((vertices, faces), (vertices * (1, 1, -1), faces[:, ::-1])))
    assert result.notes == ()
    result = run(merged((vertices, faces), (vertices, faces[:, ::-1])))
    (note,) = result.notes
    assert note.startswith(f"{n_border} boundary vertices lie exactly on another one")


def test_cuts_of_the_solver_are_no_unjoined_surfaces():
    result = run(three_sheets())
    assert result.notes == ("3 edges have more than two triangles: cut there, their vertices held",)


def test_valence_of_hundreds():
    vertices, faces = bipyramid(100)
    result = run((vertices, faces), steps=1)
    assert result.notes == ()
    assert np.linalg.norm(result.positions, axis=1).max() <= 1 + 1e-9


# Where vertices stay ------------------------------------------------------------------------------


@pytest.mark.parametrize("mesh", [bow_tie, three_sheets, moebius_strip, everything_wrong])
@pytest.mark.parametrize("boundary", ["fixed", "free"])
def test_vertices_at_cuts_stay_bit_by_bit(mesh, boundary):
    vertices, faces = mesh()
    problems = find_problems(vertices, faces)
    assert len(problems.held)
    positions = run((vertices, faces), boundary=boundary).positions
    np.testing.assert_array_equal(positions[problems.held], vertices[problems.held])
    moves = (positions != vertices).any(axis=1)
    is_on_boundary = np.isin(np.arange(len(vertices)), boundary_vertices(faces))
    assert moves.any() == (boundary == "free" or not is_on_boundary.all())


def test_problems_of_a_good_mesh_are_none():
    problems = find_problems(*random_closed(seed=2))
    assert problems.vertices.tolist() == []


def test_all_problems_are_located_together():
    vertices, faces = bow_tie()
    vertices = np.vstack([vertices, [(np.nan, 0, 0)]])
    faces = np.vstack([faces, faces[5:6]]).astype(np.int32)
    problems = find_problems(vertices, faces)
    assert problems.held.tolist() == [0]
    assert problems.not_finite.tolist() == [len(vertices) - 1]
    assert problems.left_out.tolist() == sorted(faces[5].tolist())
    assert problems.vertices.tolist() == sorted({0, len(vertices) - 1, *faces[5].tolist()})


def test_fixed_boundaries_stay_bit_by_bit():
    vertices, faces = bumpy_disc(seed=1)
    border = boundary_vertices(faces)
    # An offset, so that the way into the solver's frame and back would round.
    positions = run((vertices + 0.1, faces)).positions
    np.testing.assert_array_equal(positions[border], (vertices + 0.1)[border])
    assert (positions != vertices + 0.1).any(axis=1).sum() == len(vertices) - len(border)


def test_a_free_flat_disc_stays_flat():
    vertices, faces = flat_hexagon(4)
    result = run((vertices, faces), boundary="free")
    np.testing.assert_array_equal(result.positions[:, 2], 0)
    assert np.abs(result.positions - vertices).max() > 1e-3


def test_loose_vertices_stay_and_do_not_count_for_the_size():
    vertices, faces = random_closed(seed=1)
    alone = run((vertices, faces)).positions
    result = run((np.vstack([vertices, [(1e6, 0, 0)]]), faces))
    np.testing.assert_array_equal(result.positions[-1], (1e6, 0, 0))
    np.testing.assert_allclose(result.positions[:-1], alone, atol=1e-10)


# Scales -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("settings", SCHEMES)
@pytest.mark.parametrize("scale", [1e-30, 1e-8, 1e8, 1e30])
def test_the_unit_of_length_does_not_matter(settings, scale):
    vertices, faces = random_closed(seed=1)
    expected = run((vertices, faces), **settings)
    result = run((scale * vertices, faces), **settings)
    np.testing.assert_allclose(result.positions / scale, expected.positions, atol=1e-12)
    np.testing.assert_allclose(result.steps[0].density, expected.steps[0].density, rtol=1e-9)
    assert result.steps[-1].curvature_ratio == pytest.approx(
        expected.steps[-1].curvature_ratio, rel=1e-9
    )


def test_powers_of_two_change_nothing_at_all():
    vertices, faces = random_closed(seed=1)
    result = run((2.0**40 * vertices, faces))
    np.testing.assert_array_equal(result.positions, 2.0**40 * run((vertices, faces)).positions)


@pytest.mark.parametrize("settings", SCHEMES)
def test_a_huge_offset_costs_only_the_digits_it_takes(settings):
    vertices, faces = random_closed(seed=1)
    offset = np.array([1e6, -2e6, 3e6])
    expected = run((vertices, faces), **settings).positions
    result = run((vertices + offset, faces), **settings).positions
    np.testing.assert_allclose(result - offset, expected, atol=1e-8)


@pytest.mark.parametrize("settings", SCHEMES)
def test_components_of_very_different_size_stay_finite_and_apart(settings):
    vertices, faces = random_closed(seed=1)
    small = 1e-9 * vertices + 2
    result = run(merged((vertices, faces), (small, faces)), **settings).positions
    np.testing.assert_allclose(result[len(vertices) :], small, atol=1e-8)


@pytest.mark.parametrize("settings", SCHEMES)
def test_a_tiny_timestep_moves_nothing(settings):
    vertices, faces = random_closed(seed=1)
    result = run((vertices, faces), **settings, tau=1e-12)
    np.testing.assert_allclose(result.positions, vertices, atol=1e-8)


@pytest.mark.parametrize("settings", SCHEMES)
@pytest.mark.parametrize("tau", [1e6, 9e29])
def test_a_huge_timestep_shrinks_to_a_point_at_worst(settings, tau):
    vertices, faces = random_closed(seed=1)
    result = run((vertices, faces), **settings, tau=tau, steps=3)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    assert ((result.positions >= low) & (result.positions <= high)).all()
    assert np.ptp(result.positions, axis=0).max() < 1e-3


@pytest.mark.parametrize("settings", SCHEMES)
def test_a_huge_timestep_in_a_fixed_frame_reaches_a_still_surface(settings):
    vertices, faces = bumpy_disc(seed=1)
    result = run((vertices, faces), **settings, tau=1e6)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    slack = 0.05 * (high - low).max()
    assert ((result.positions >= low - slack) & (result.positions <= high + slack)).all()


@pytest.mark.parametrize("scale", [1e-38, 9e38 / 2])
@pytest.mark.parametrize("tau", [2e-30, 9e29])
@pytest.mark.parametrize("settings", SCHEMES)
def test_the_ends_of_all_ranges_without_the_paper_s_frame(settings, scale, tau):
    vertices, faces = random_closed(seed=1)
    run((scale * vertices, faces), **settings, tau=tau, normalize=False)
