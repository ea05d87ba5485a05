"""A prepared mesh: other positions of the same surface, without analysing it anew."""

from dataclasses import astuple, replace

import numpy as np
import pytest
from support.bad_meshes import everything_wrong
from support.meshes import bipyramid, bumpy_disc, latlong_sphere, random_closed

from adaptive_fairing.core import (
    FairingSettings,
    InputError,
    PreparedMesh,
    denoise,
    fair,
)
from adaptive_fairing.core.problem import prepared_surface

SETTINGS = FairingSettings(tau=0.016, steps=2)
MESHES = {
    "closed": random_closed(seed=3),
    "open": bumpy_disc(seed=3),
    "everything wrong": everything_wrong(),
}


def bent(vertices):
    """Another frame of the surface, without another longest axis."""
    return vertices + 0.05 * np.sin(vertices[:, [1, 2, 0]])


def apart(vertices, distance):
    """The surface and a copy of it at a distance."""
    return np.concatenate([vertices, vertices + np.array([distance, 0, 0])])


@pytest.mark.parametrize("name", MESHES)
def test_the_first_frame_is_bit_by_bit_what_it_is_alone(name):
    vertices, faces = MESHES[name]
    mesh = PreparedMesh(vertices, faces)
    alone = fair(vertices, faces, SETTINGS)
    for _ in range(2):  # nothing of a solve is left in the preparation
        with_help = fair(vertices, faces, SETTINGS, prepared=mesh)
        assert np.array_equal(with_help.positions, alone.positions)
        assert with_help.notes == alone.notes


@pytest.mark.parametrize("name", MESHES)
def test_another_frame_is_what_it_is_alone_up_to_the_solvers_tolerance(name):
    """The order of the vertices may differ, the rest does not; slivers enlarge the rounding."""
    vertices, faces = MESHES[name]
    mesh = PreparedMesh(vertices, faces)
    tight = replace(SETTINGS, cg_tolerance=1e-13)
    alone = fair(bent(vertices), faces, tight)
    with_help = fair(bent(vertices), faces, tight, prepared=mesh)
    # Coordinates of that mesh reach 1e6, and its slivers enlarge the rounding: 1e-8 to 2e-7 was
    # seen for bends of 0.05 to 0.055, whatever the order of the sums.
    bound = 1e-6 if name == "everything wrong" else 1e-11
    np.testing.assert_allclose(with_help.positions, alone.positions, rtol=0, atol=bound)


def test_the_topology_is_analysed_once(made_spaces):
    vertices, faces = MESHES["closed"]
    mesh = PreparedMesh(vertices, faces)
    for _ in range(3):
        vertices = bent(vertices)
        fair(vertices, faces, SETTINGS, prepared=mesh)
    assert len(made_spaces) == 1


def test_both_algorithms_share_a_space_and_denoise_makes_no_matrices_in_it(made_spaces):
    """It only measures energy, area and volume."""
    vertices, faces = MESHES["closed"]
    mesh = PreparedMesh(vertices, faces)
    result = denoise(vertices, faces, prepared=mesh)
    (space,) = made_spaces
    assert not {"pattern", "_entries"} & vars(space).keys()
    steps = fair(vertices, faces, SETTINGS, prepared=mesh)
    assert {"pattern", "_entries"} < vars(space).keys()
    assert len(made_spaces) == 1
    assert astuple(result.initial) == pytest.approx(astuple(steps.initial), rel=1e-12)


@pytest.mark.parametrize("density", ["edge_length", "area"])
@pytest.mark.parametrize("method", ["uniform", "adaptive_timestep", "adaptive_tensor"])
def test_a_kept_scale_means_the_same_time_in_the_units_of_the_mesh(method, density):
    """A part that moves away enlarges the box; what stays is smoothed as before only if kept."""
    vertices, faces = MESHES["closed"]
    near = apart(vertices, 3.0)
    far = apart(vertices, 9.0)
    both = np.concatenate([faces, faces + len(vertices)])
    settings = replace(SETTINGS, method=method, density=density, cg_tolerance=1e-13)
    kept = PreparedMesh(far, both, scale=PreparedMesh(near, both).own_scale)
    n = len(vertices)
    first = fair(near, both, settings, prepared=kept).positions[:n]
    np.testing.assert_allclose(
        fair(far, both, settings, prepared=kept).positions[:n], first, rtol=0, atol=1e-10
    )
    own = PreparedMesh(near, both)
    change = np.abs(fair(far, both, settings, prepared=own).positions[:n] - first).max()
    is_free_of_scale = density == "area" and method != "uniform"
    assert change < 1e-10 if is_free_of_scale else change > 1e-3


def test_other_triangles_are_refused():
    vertices, faces = MESHES["closed"]
    mesh = PreparedMesh(vertices, faces)
    for others in (faces[1:], faces[::-1]):
        with pytest.raises(InputError, match="other triangles"):
            fair(vertices, others, SETTINGS, prepared=mesh)
    with pytest.raises(InputError, match="other triangles"):
        fair(np.vstack([vertices, [0, 0, 0]]), faces, SETTINGS, prepared=mesh)


def test_another_quadrature_is_refused():
    vertices, faces = MESHES["closed"]
    mesh = PreparedMesh(vertices, faces)
    finer = replace(SETTINGS, quadrature_tolerance=1e-5)
    with pytest.raises(InputError, match=r"prepared with quadrature_tolerance 0.001, .* 1e-05"):
        fair(vertices, faces, finer, prepared=mesh)


@pytest.mark.parametrize(
    ("algorithm", "valence"), [(fair, 1_000), (fair, 20_000), (denoise, 2_000), (denoise, 20_000)]
)
def test_too_many_neighbours_are_refused_before_any_work(algorithm, valence, monkeypatch):
    vertices, faces = bipyramid(valence)
    monkeypatch.setattr(prepared_surface, "PatchSet", None)  # where the work would begin
    message = rf"2 vertices have more than 100 neighbours, up to {valence}: vertices {valence}, "
    with pytest.raises(InputError, match=message):
        algorithm(vertices, faces)


def test_a_space_that_serves_denoise_is_refused_to_fair():
    """Poles that `denoise` can treat would take the paper's method minutes."""
    mesh = PreparedMesh(*bipyramid(700))
    mesh.space_for("denoise")
    with pytest.raises(InputError, match="a run would take minutes"):
        mesh.space_for("fair")


def test_poles_of_a_few_hundred_neighbours_are_solved():
    vertices, faces = latlong_sphere(128, 3)
    noise = np.random.default_rng(0).normal(size=vertices.shape)
    result = fair(vertices + 0.002 * noise, faces, FairingSettings(steps=1))
    assert result.stop_reason == "steps"
    assert np.isfinite(result.positions).all()


def test_the_patches_of_an_estimate_serve_the_solve(monkeypatch):
    made = []

    class Counted(prepared_surface.PatchSet):
        def __init__(self, *arguments):
            made.append(self)
            super().__init__(*arguments)

    monkeypatch.setattr(prepared_surface, "PatchSet", Counted)
    vertices, faces = MESHES["closed"]
    mesh = PreparedMesh(vertices, faces)
    assert min(mesh.needed_bytes("fair"), mesh.needed_bytes("denoise")) > 0
    fair(vertices, faces, SETTINGS, prepared=mesh)
    fair(vertices, faces, SETTINGS, prepared=mesh)
    assert len(made) == 1
