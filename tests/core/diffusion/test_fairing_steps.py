"""One step is the paper's linear system; a run is its steps, one by one."""

from itertools import islice

import numpy as np
import pytest
from scipy import linalg
from support import meshes
from support.reference import BruteForceSpace

from adaptive_fairing.core import (
    FairingSettings,
    LoopSpace,
    TriangleTopology,
    fair,
    fair_steps,
    mesh_density,
)
from adaptive_fairing.core.diffusion import steps as diffusion_steps
from adaptive_fairing.core.problem import prepared_surface

METHODS = ("uniform", "adaptive_timestep", "adaptive_tensor")
EXACT = {"cg_tolerance": 1e-12, "normalize": False}


def solved_directly(mass, stiffness, vertices):
    return linalg.solve(mass + stiffness, mass @ vertices, assume_a="pos")


def scheme_fields(method, tau, density):
    """(timestep, diffusivity) of (3.4) and (3.9)."""
    if method == "adaptive_tensor":
        return None, tau * density
    return (tau * density if method == "adaptive_timestep" else np.full(len(density), tau)), None


# The linear system -------------------------------------------------------------------------------


@pytest.mark.parametrize("density_kind", ["edge_length", "area"])
@pytest.mark.parametrize("method", METHODS)
def test_step_solves_the_papers_system(method, density_kind):
    vertices, faces = meshes.random_closed(1)
    settings = FairingSettings(method=method, tau=0.05, steps=1, density=density_kind, **EXACT)
    topology = TriangleTopology(faces, len(vertices))
    density = mesh_density(topology, vertices, density_kind)
    timestep, diffusivity = scheme_fields(method, 0.05, density)
    space = LoopSpace(topology)
    expected = solved_directly(
        space.mass_matrix(vertices, timestep=timestep).toarray(),
        space.stiffness_matrix(vertices, diffusivity=diffusivity).toarray(),
        vertices,
    )
    [step] = fair_steps(vertices, faces, settings)
    np.testing.assert_allclose(step.positions, expected, atol=1e-10)
    np.testing.assert_allclose(step.density, density, rtol=1e-10)


@pytest.mark.parametrize("method", METHODS)
def test_step_agrees_with_brute_force(method):
    """No piece of the program in the expected value but the density, tested elsewhere."""
    vertices, faces = meshes.icosahedron()
    vertices = vertices + 0.1 * np.random.default_rng(8).normal(size=vertices.shape)
    tau = 0.1
    settings = FairingSettings(method=method, tau=tau, steps=1, quadrature_tolerance=1e-6, **EXACT)
    density = mesh_density(TriangleTopology(faces, len(vertices)), vertices)
    timestep, diffusivity = scheme_fields(method, tau, density)
    reference = BruteForceSpace(faces)
    expected = solved_directly(
        reference.mass_matrix(vertices, timestep),
        reference.stiffness_matrix(vertices, diffusivity),
        vertices,
    )
    np.testing.assert_allclose(fair(vertices, faces, settings).positions, expected, atol=2e-5)


def test_every_step_starts_from_the_surface_before():
    mesh = meshes.noisy_ball(2, 0.03)
    settings = FairingSettings(tau=0.016, steps=3, **EXACT)
    several = fair(*mesh, settings)
    positions = mesh[0]
    one = FairingSettings(tau=0.016, steps=1, **EXACT)
    for step in several.steps:
        single = fair(positions, mesh[1], one)
        np.testing.assert_allclose(step.positions, single.positions, atol=1e-10)
        np.testing.assert_allclose(step.density, single.steps[0].density, rtol=1e-8)
        positions = single.positions


@pytest.mark.parametrize(
    "mesh",
    [meshes.tetrahedron(), meshes.octahedron(), meshes.icosahedron()],
    ids=["tetrahedron", "octahedron", "icosahedron"],
)
def test_schemes_are_equal_where_the_density_is_constant(mesh):
    tau = 0.1
    density = mesh_density(TriangleTopology(mesh[1], len(mesh[0])), mesh[0])
    np.testing.assert_allclose(density, density[0], rtol=1e-12)
    timestep, tensor, uniform = (
        fair(*mesh, FairingSettings(method=method, tau=used, steps=3, **EXACT)).steps[0].positions
        for method, used in (
            ("adaptive_timestep", tau),
            ("adaptive_tensor", tau),
            ("uniform", tau * density[0]),
        )
    )
    assert np.abs(timestep - mesh[0]).max() > 0.01
    np.testing.assert_allclose(tensor, timestep, atol=1e-10)
    np.testing.assert_allclose(uniform, timestep, atol=1e-10)


def test_schemes_differ_where_the_density_varies():
    mesh = meshes.graded_sphere(2)
    uniform, timestep, tensor = (
        fair(*mesh, FairingSettings(method=method, tau=0.05, steps=1)).positions
        for method in METHODS
    )
    assert np.abs(timestep - tensor).max() > 1e-3
    assert np.abs(timestep - uniform).max() > 1e-3


# Invariance --------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
def test_scale_and_place_do_not_matter(method):
    """With the mesh scaled into the frame [-3, 3]^3, as by default."""
    vertices, faces = meshes.noisy_ball(2, 0.03)
    settings = FairingSettings(method=method, cg_tolerance=1e-12)
    plain = fair(vertices, faces, settings)
    moved = fair(40 * vertices + (100, -20, 3), faces, settings)
    np.testing.assert_allclose(
        moved.positions, 40 * plain.positions + (100, -20, 3), atol=40 * 1e-9
    )
    for step, other in zip(plain.steps, moved.steps, strict=True):
        np.testing.assert_allclose(other.density, step.density, rtol=1e-7)
        assert other.area == pytest.approx(40**2 * step.area, rel=1e-8)
        assert other.volume == pytest.approx(40**3 * step.volume, rel=1e-8)
        assert other.curvature_energy == pytest.approx(step.curvature_energy, rel=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_rotation_numbering_and_face_starts_do_not_matter(method):
    vertices, faces = meshes.noisy_ball(2, 0.03)
    settings = FairingSettings(method=method, tau=0.02, steps=2, **EXACT)
    plain = fair(vertices, faces, settings).positions
    generator = np.random.default_rng(1)
    rotation = linalg.expm(np.array([(0, -0.4, 0.9), (0.4, 0, -1.3), (-0.9, 1.3, 0)]))
    rotated = fair(vertices @ rotation.T, faces, settings).positions
    np.testing.assert_allclose(rotated, plain @ rotation.T, atol=1e-9)

    order = generator.permutation(len(vertices))
    scrambled = np.empty_like(vertices)
    scrambled[order] = vertices
    shifts = (np.arange(3) + generator.integers(0, 3, len(faces))[:, None]) % 3
    other_faces = generator.permutation(order[np.take_along_axis(faces, shifts, axis=1)])
    np.testing.assert_allclose(
        fair(scrambled, other_faces, settings).positions[order], plain, atol=1e-9
    )


def test_frame_is_the_box_of_6_and_density_is_measured_there():
    vertices, faces = meshes.noisy_ball(2, 0.03)
    topology = TriangleTopology(faces, len(vertices))
    scale = 6 / np.ptp(vertices, axis=0).max()
    steps = fair(vertices, faces, FairingSettings(steps=2)).steps
    for step, positions in zip(steps, (vertices, steps[0].positions), strict=True):
        np.testing.assert_allclose(
            step.density, mesh_density(topology, scale * positions), rtol=1e-10
        )
    in_frame = fair(scale * vertices, faces, FairingSettings(steps=2, normalize=False))
    np.testing.assert_allclose(in_frame.positions, scale * steps[1].positions, atol=1e-5)


# What a step reports -----------------------------------------------------------------------------


def test_steps_report_index_time_and_the_measures_of_their_limit_surface():
    vertices, faces = meshes.noisy_ball(2, 0.03)
    result = fair(vertices, faces, FairingSettings(tau=0.01, steps=3))
    space = LoopSpace(TriangleTopology(faces, len(vertices)))
    initial = space.measures(vertices)
    assert result.initial.area == pytest.approx(initial.area, rel=1e-10)
    for index, step in enumerate(result.steps, start=1):
        assert step.index == index
        assert step.time == pytest.approx(0.01 * index)
        assert step.positions.dtype == np.float64
        assert step.positions.shape == vertices.shape
        assert step.density.shape == (len(vertices),)
        measures = space.measures(step.positions)
        assert step.area == pytest.approx(measures.area, rel=1e-10)
        # By the divergence theorem, whose origin shows in the quadrature error.
        assert step.volume == pytest.approx(measures.volume, rel=1e-6)
        assert step.curvature_energy == pytest.approx(measures.curvature_energy, rel=1e-9)
        assert step.curvature_ratio == pytest.approx(
            measures.curvature_energy / initial.curvature_energy, rel=1e-9
        )
        assert step.initial == result.initial
    assert result.positions is result.steps[-1].positions


def test_volume_of_an_open_surface_is_not_a_number():
    result = fair(*meshes.bumpy_disc(0), FairingSettings(steps=1))
    assert np.isnan(result.steps[0].volume)
    assert np.isnan(result.initial.volume)


def test_solve_report_states_the_true_residual():
    """|M X(0) - A x| / |m X(0)| in the norm of the inverse diagonal, with lumped masses m."""
    vertices, faces = meshes.noisy_ball(2, 0.03)
    vertices[0] *= 4
    vertices -= vertices.mean(axis=0)  # where the origin is, far from the middle of the box
    for tolerance in (1e-3, 1e-6, 1e-9):
        settings = FairingSettings(steps=1, cg_tolerance=tolerance, normalize=False)
        [step] = fair_steps(vertices, faces, settings)
        topology = TriangleTopology(faces, len(vertices))
        space = LoopSpace(topology)
        timestep = step.tau * mesh_density(topology, vertices)
        mass = space.mass_matrix(vertices, timestep=timestep)
        matrix = mass + space.stiffness_matrix(vertices)
        inverse = 1 / matrix.diagonal()[:, None]
        right_side = mass @ vertices
        residual = right_side - matrix @ step.positions
        lumped = mass.sum(axis=1)[:, None] * vertices
        relative = np.sqrt(np.sum(inverse * residual**2) / np.sum(inverse * lumped**2))
        assert step.solve.converged
        assert 1 <= step.solve.iterations <= 40
        assert step.solve.residual <= tolerance
        assert step.solve.residual == pytest.approx(relative, rel=1e-2, abs=1e-14)


def test_tighter_tolerance_takes_more_iterations():
    mesh = meshes.noisy_ball(2, 0.03)
    iterations = [
        fair(*mesh, FairingSettings(steps=1, cg_tolerance=tolerance)).steps[0].solve.iterations
        for tolerance in (1e-2, 1e-5, 1e-8)
    ]
    assert iterations == sorted(set(iterations))


# The generator -----------------------------------------------------------------------------------


def test_no_system_is_solved_before_its_step_is_asked_for(monkeypatch):
    solves = []

    def counted(*args, **kwargs):
        solves.append(1)
        return solve(*args, **kwargs)

    solve = diffusion_steps.conjugate_gradients
    monkeypatch.setattr(diffusion_steps, "conjugate_gradients", counted)
    steps = fair_steps(*meshes.noisy_ball(2, 0.03), FairingSettings(steps=4))
    assert len(solves) == 0
    for asked in (1, 2, 3):
        assert next(steps).index == asked
        assert len(solves) == asked
    steps.close()
    assert len(solves) == 3


def test_tables_and_sparsity_pattern_are_made_once(monkeypatch):
    spaces = []

    class CountedSpace(LoopSpace):
        def __init__(self, *args, **kwargs):
            spaces.append(1)
            super().__init__(*args, **kwargs)

    monkeypatch.setattr(prepared_surface, "LoopSpace", CountedSpace)
    assert len(list(fair_steps(*meshes.noisy_ball(2, 0.03), FairingSettings(steps=3)))) == 3
    assert len(spaces) == 1


def test_inputs_are_neither_changed_nor_read_again():
    vertices, faces = meshes.noisy_ball(2, 0.03)
    weights = np.linspace(0, 1, len(vertices))
    originals = vertices.copy(), faces.copy(), weights.copy()
    for array in (vertices, faces, weights):
        array.setflags(write=False)
    undisturbed = fair(vertices, faces, weights=weights).positions
    for array, original in zip((vertices, faces, weights), originals, strict=True):
        np.testing.assert_array_equal(array, original)

    for array in (vertices, faces, weights):
        array.setflags(write=True)
    steps = fair_steps(vertices, faces, weights=weights)
    first = next(steps)
    vertices[:], faces[:], weights[:] = 0, 0, 0
    first.positions[:] = 0  # a step's arrays belong to the caller
    first.density[:] = 0
    *_, last = steps
    np.testing.assert_array_equal(last.positions, undisturbed)


def test_runs_repeat_bit_by_bit():
    mesh = meshes.noisy_ball(3, 0.03)
    first, second = (fair(*mesh, FairingSettings(steps=2)).positions for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_lists_and_other_number_types_are_accepted():
    vertices, faces = meshes.icosahedron()
    expected = fair(vertices.astype(np.float32), faces).positions
    for other in (vertices.astype(np.float32).tolist(), vertices.astype(">f4")):
        np.testing.assert_array_equal(fair(other, faces.tolist()).positions, expected)
    np.testing.assert_array_equal(
        fair(vertices.astype(np.float32), faces.astype(np.uint64)).positions, expected
    )


def test_fair_yields_the_steps_of_the_generator():
    mesh = meshes.noisy_ball(2, 0.03)
    settings = FairingSettings(steps=3)
    result = fair(*mesh, settings)
    assert result.settings is settings
    for step, other in zip(result.steps, islice(fair_steps(*mesh, settings), 9), strict=True):
        np.testing.assert_array_equal(step.positions, other.positions)


# What it is for ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "tau"), [("uniform", 0.03), ("adaptive_timestep", 0.07), ("adaptive_tensor", 0.07)]
)
def test_noise_goes_down_and_the_shape_stays_in_place(method, tau):
    clean, faces = meshes.icosphere(3)
    noisy = clean + 0.02 * np.random.default_rng(5).normal(size=(len(clean), 1)) * clean
    result = fair(noisy, faces, FairingSettings(method=method, tau=tau, steps=3))
    before, after = (np.linalg.norm(x, axis=1) for x in (noisy, result.positions))
    assert after.std() < 0.4 * before.std()
    np.testing.assert_allclose(result.positions.mean(axis=0), noisy.mean(axis=0), atol=2e-3)
    assert (np.diff([1.0] + [step.curvature_ratio for step in result.steps]) < 0).all()
    assert (np.diff([result.initial.area] + [step.area for step in result.steps]) < 0).all()


def test_adaptive_timestep_beats_every_uniform_one_where_the_density_varies():
    """The point of the paper: no single timestep suits edges that differ by a factor of 16.

    Noise is a share of the local edge, and so is the error; what counts is the worse of the dense
    and the coarse quarter of the vertices, each scheme at its best tau.
    """
    clean, faces = meshes.graded_sphere(4)
    start, end = np.vstack([meshes.edges_of(faces), meshes.edges_of(faces)[:, ::-1]]).T
    lengths = np.linalg.norm(clean[start] - clean[end], axis=1)
    edge = np.bincount(start, lengths) / np.bincount(start)
    noise = 0.15 * edge * np.random.default_rng(1).normal(size=len(clean))
    noisy = clean * (1 + noise)[:, None]
    quarters = edge <= np.quantile(edge, 0.25), edge >= np.quantile(edge, 0.75)

    def worst_error(method, tau):
        result = fair(noisy, faces, FairingSettings(method=method, tau=tau))
        error = (np.linalg.norm(result.positions, axis=1) - 1) / edge
        return max(np.sqrt(np.mean(error[quarter] ** 2)) for quarter in quarters)

    adaptive = min(worst_error("adaptive_timestep", tau) for tau in (0.008, 0.016, 0.032))
    uniform = min(worst_error("uniform", tau) for tau in (0.0005, 0.001, 0.0014, 0.002, 0.004))
    assert adaptive < 0.6 * 0.15
    assert adaptive < 0.85 * uniform


def test_collapse_of_a_thin_neck_is_noted_when_it_begins():
    vertices, faces = meshes.latlong_sphere(16, 31)
    vertices[:, :2] *= 0.15 + np.abs(vertices[:, 2:])
    vertices[:, 2] *= 2
    result = fair(vertices, faces, FairingSettings(method="uniform", tau=0.02, steps=8))
    ratios = np.array([1.0] + [step.curvature_ratio for step in result.steps])
    rises = ratios[1:] / np.minimum.accumulate(ratios)[1:]
    noted = [any("collapsing" in note for note in step.notes) for step in result.steps]
    assert noted == (rises > 2).tolist()
    assert noted[-1] and not noted[0]
