"""The smoothing radius: what τ means in local edge lengths."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.meshes import flat_hexagon, graded_sphere, icosphere, noisy_ball

from adaptive_fairing.core import FairingSettings, InputError, fair
from adaptive_fairing.core.diffusion.smoothing_radius import (
    equivalent_uniform_tau,
    radius_scale,
    suggest_tau,
)

SETTINGS = [
    FairingSettings(method=method, density=density)
    for method in ("uniform", "adaptive_timestep", "adaptive_tensor")
    for density in ("edge_length", "area")
]


@pytest.mark.parametrize("settings", SETTINGS, ids=lambda s: f"{s.method}-{s.density}")
def test_the_suggested_tau_gives_the_wanted_radius(settings):
    scale = radius_scale(*graded_sphere(3), settings)
    tau = suggest_tau(scale, 1.7, steps=5)
    assert scale.radii(5 * tau)[1] == pytest.approx(1.7, rel=1e-12)


@pytest.mark.parametrize("settings", SETTINGS, ids=lambda s: f"{s.method}-{s.density}")
def test_size_and_place_of_the_mesh_do_not_matter_in_the_frame(settings):
    vertices, faces = graded_sphere(3)
    one = radius_scale(vertices, faces, settings)
    other = radius_scale(1e-3 * vertices + 5.0, faces, settings)
    assert other.radii(1.0) == pytest.approx(one.radii(1.0), rel=1e-9)
    assert other.edge_densest == pytest.approx(1e-3 * one.edge_densest, rel=1e-9)


def test_without_the_frame_time_is_in_squared_units_of_the_mesh():
    vertices, faces = icosphere(2)
    settings = FairingSettings(method="uniform", normalize=False)
    one = radius_scale(vertices, faces, settings)
    tenfold = radius_scale(10 * vertices, faces, settings)
    assert tenfold.typical == pytest.approx(one.typical / 10, rel=1e-12)


def test_uniform_time_smooths_the_densest_part_over_the_most_edges():
    scale = radius_scale(*graded_sphere(4), FairingSettings(method="uniform"))
    assert scale.edge_densest < scale.edge_typical < scale.edge_coarsest
    # One T everywhere: the radius in object units is the same in the three parts.
    lengths = np.array([scale.densest, scale.typical, scale.coarsest]) * np.array(
        [scale.edge_densest, scale.edge_typical, scale.edge_coarsest]
    )
    assert lengths[0] == pytest.approx(lengths[2], rel=0.05)


def test_area_density_has_nearly_one_radius_everywhere():
    area = radius_scale(*graded_sphere(4), FairingSettings(density="area", density_passes=0))
    edge = radius_scale(*graded_sphere(4), FairingSettings(density_passes=0))
    uniform = radius_scale(*graded_sphere(4), FairingSettings(method="uniform"))
    spread = [scale.densest / scale.coarsest for scale in (area, edge, uniform)]
    assert spread[0] < spread[1] < spread[2]
    assert spread[0] == pytest.approx(1.0, abs=0.25)


def test_a_flat_ripple_of_known_wavelength_shrinks_as_the_radius_says():
    """Heat flow takes a wave sin(kx) down by exp(-k² T) = exp(-k² r² / 2), r the radius."""
    vertices, faces = flat_hexagon(24)
    vertices -= vertices.mean(axis=0)
    k = 2 * np.pi / (np.ptp(vertices[:, 0]) / 4)
    wavy = vertices.copy()
    wavy[:, 2] = 1e-4 * np.sin(k * vertices[:, 0])
    n_steps, radius = 20, 2.0
    settings = FairingSettings(method="uniform", steps=n_steps)
    scale = radius_scale(wavy, faces, settings)
    settings = FairingSettings(
        method="uniform", steps=n_steps, tau=suggest_tau(scale, radius, n_steps), cg_tolerance=1e-10
    )
    centre = np.linalg.norm(vertices, axis=1) < 0.4 * np.ptp(vertices[:, 0]) / 2
    faired = fair(wavy, faces, settings).positions
    wave = np.sin(k * vertices[centre, 0])
    left = (faired[centre, 2] @ wave) / (wavy[centre, 2] @ wave)
    expected = np.exp(-((k * radius * scale.edge_typical) ** 2) / 2)
    assert left == pytest.approx(expected, rel=0.05)


def test_the_equivalent_uniform_tau_is_the_mean_local_time():
    vertices, faces = graded_sphere(3)
    settings = FairingSettings(tau=0.02)
    density = fair(vertices, faces, settings).steps[0].density
    expected = 0.02 * density.mean()
    assert equivalent_uniform_tau(vertices, faces, settings) == pytest.approx(expected, rel=1e-9)
    uniform = FairingSettings(method="uniform", tau=0.02)
    assert equivalent_uniform_tau(vertices, faces, uniform) == 0.02


@pytest.mark.parametrize("settings", SETTINGS, ids=lambda s: f"{s.method}-{s.density}")
def test_without_tau_a_run_takes_the_one_that_its_radius_asks_for(settings):
    vertices, faces = graded_sphere(2)
    settings = replace(settings, radius=0.8, steps=3)
    asked = suggest_tau(radius_scale(vertices, faces, settings), 0.8, 3)
    by_radius = fair(vertices, faces, settings)
    by_tau = fair(vertices, faces, replace(settings, tau=asked))
    for index, (one, other) in enumerate(zip(by_radius.steps, by_tau.steps, strict=True), start=1):
        assert one.tau == pytest.approx(asked, rel=1e-12)
        assert other.tau == asked
        assert one.time == pytest.approx(index * asked, rel=1e-12)
        np.testing.assert_allclose(one.positions, other.positions, atol=1e-12)


@pytest.mark.parametrize("density", ["edge_length", "area"])
def test_the_default_does_the_same_to_a_coarse_and_to_a_dense_mesh(density):
    """White noise in proportion to the edges: the part that is left does not know their number."""
    left = []
    for levels in (3, 4, 5):
        vertices, faces = icosphere(levels)
        edge = radius_scale(vertices, faces, FairingSettings()).edge_typical
        heights = np.random.default_rng(1).normal(scale=0.2 * edge, size=len(vertices))
        noisy = vertices * (1 + heights[:, None])
        faired = np.linalg.norm(
            fair(noisy, faces, FairingSettings(density=density)).positions, axis=1
        )
        left.append(np.std(faired) / np.std(heights))
    assert max(left) < 0.6
    assert left == pytest.approx([left[1]] * 3, rel=0.05)


@pytest.mark.parametrize("normalize", ["box", "sphere", False])
@pytest.mark.parametrize("settings", SETTINGS, ids=lambda s: f"{s.method}-{s.density}")
def test_without_tau_the_frame_and_a_turn_change_nothing(settings, normalize):
    vertices, faces = noisy_ball(2, 0.03)
    vertices = vertices * (1, 2, 3)
    turn = Rotation.from_euler("xyz", [0.3, 1.1, 2.2]).as_matrix()
    expected = fair(vertices, faces, settings).positions
    assert np.abs(expected - vertices).max() > 0.01
    framed = replace(settings, normalize=normalize)
    np.testing.assert_allclose(fair(vertices, faces, framed).positions, expected, atol=1e-12)
    turned = fair(vertices @ turn.T, faces, framed).positions
    np.testing.assert_allclose(turned, expected @ turn.T, atol=1e-12)


def test_one_tau_in_the_frame_of_the_sphere_does_not_know_of_turns():
    vertices, faces = noisy_ball(2, 0.03)
    vertices = vertices * (1, 2, 3)
    turn = Rotation.from_euler("xyz", [0.3, 1.1, 2.2]).as_matrix()
    difference = {}
    for normalize in ("box", "sphere"):
        settings = FairingSettings(tau=0.02, normalize=normalize)
        straight = fair(vertices, faces, settings).positions
        turned = fair(vertices @ turn.T, faces, settings).positions
        difference[normalize] = np.abs(turned - straight @ turn.T).max()
    assert difference["sphere"] < 1e-12
    assert difference["box"] > 1e-4


def test_a_radius_beyond_all_times_is_refused():
    vertices, faces = icosphere(1)
    settings = FairingSettings(method="uniform", normalize=False)
    with pytest.raises(InputError, match=r"a radius of 0\.5 edges means τ = .*box"):
        fair(1e38 * vertices, faces, settings)


def test_loose_vertices_change_nothing():
    vertices, faces = icosphere(2)
    more = np.concatenate([vertices, [[50.0, 0.0, 0.0]]])
    settings = FairingSettings()
    assert radius_scale(more, faces, settings).radii(1.0) == pytest.approx(
        radius_scale(vertices, faces, settings).radii(1.0), rel=1e-12
    )


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "no triangles"),
        (np.zeros((3, 3)), np.array([[0, 1, 2]]), "no edge .* has a length"),
    ],
)
def test_nothing_to_measure_is_refused(vertices, faces, message):
    with pytest.raises(InputError, match=message):
        radius_scale(vertices, faces, FairingSettings())
