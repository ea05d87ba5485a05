"""Smooth noise over several edges: what can be told, and what the user decides."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.noise.smooth_noise import (
    SmoothNoise,
    smooth_noise,
)
from adaptive_fairing.core.denoising.noise_model import NoiseCorrelation
from adaptive_fairing.core.denoising.parameters import parameters
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

VERTICES, FACES = meshes.torus(104, 52)
TOPOLOGY = TriangleTopology(FACES, len(VERTICES))
FRAME = TriangleSurface(TOPOLOGY, VERTICES)


def noisy(level, passes=8, seed=0):
    heights = FRAME.spread(np.random.default_rng(seed).normal(size=len(VERTICES)), passes)
    return VERTICES + FRAME.raised(level * heights / heights.std())


def found(points):
    everywhere = np.ones(len(points), dtype=bool)
    return smooth_noise(NoisySurface(points, FRAME), everywhere)


def heights(passes=4, seed=0):
    """Smooth noise of unit size, in local edge lengths."""
    white = np.random.default_rng(seed).normal(size=len(VERTICES))
    smooth = FRAME.spread(white, passes)
    return smooth / smooth.std()


@pytest.mark.parametrize("level", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("passes", [4, 8])
def test_it_is_even_and_its_level_is_about_right(level, passes):
    smooth = found(noisy(level, passes))
    assert smooth.may_be_noise
    assert 0.6 * level < smooth.level < 1.5 * level
    assert passes / 2 <= smooth.correlation.passes <= 2 * passes


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("passes", [2, 3, 4, 6])
def test_it_is_told_from_shape_where_it_is_narrow(passes, seed):
    assert found(noisy(0.2, passes, seed)).is_noise


TOLD = SmoothNoise(
    level=0.2,
    correlation=NoiseCorrelation(seen=0.3, deviation=0.3, passes=4),
    misfit=0.025,
    excess=0.2,
    evenness=0.95,
    outliers=1.0,
    lean=0.01,
    is_enough=True,
    least_evidence=parameters().least_evidence,
)


@pytest.mark.parametrize(
    "wrong",
    [
        {"evenness": 0.7},
        {"correlation": NoiseCorrelation(passes=1)},
        {"misfit": 1.0},
        {"excess": 1.0},
        {"presence": 0.3},
        {"outliers": 1.5},
        {"outliers": 0.3},
        {"lean": 0.1},
        {"is_enough": False},
        {"least_evidence": 5.0},
    ],
)
def test_what_is_wrong_enough_is_no_noise(wrong):
    assert TOLD.is_noise
    assert not TOLD._replace(**wrong).is_noise


def test_what_speaks_against_noise_takes_evidence_from_it():
    worse = {"misfit": 0.03, "evenness": 0.9, "outliers": 1.1, "lean": 0.02}
    for name, value in worse.items():
        assert TOLD._replace(**{name: value}).evidence < TOLD.evidence
    # Perfect noise is no more so than this.
    assert TOLD._replace(misfit=0.0, evenness=2.0, outliers=0.9, lean=0.0).evidence < 4


def test_where_the_odds_are_even_or_it_goes_on_growing_a_note_says_that_it_may_be_noise():
    for unclear in ({"evenness": 0.7}, {"excess": 1.0}, {"presence": 0.1}):
        smooth = TOLD._replace(**unclear)
        assert smooth.is_likely
        assert not smooth.is_noise
    assert not TOLD._replace(evenness=0.4).is_likely


def test_noise_is_in_all_hinges_and_flat_facets_have_none():
    """Facets that were divided are even, and their bands like those of noise."""
    points, faces = meshes.divided(*meshes.icosphere(2), 5)
    everywhere = np.ones(len(points), dtype=bool)
    frame = TriangleSurface(TriangleTopology(faces, len(points)), points)
    facets = smooth_noise(NoisySurface(points, frame), everywhere)
    assert facets.presence < 0.3
    assert not facets.is_noise
    assert facets._replace(presence=1.0).is_noise
    for passes in (2, 4, 8):
        assert found(noisy(0.2, passes)).presence > 1.4 * parameters().least_presence


@pytest.mark.parametrize("shape", ["bumps", "ridges"])
def test_shape_on_a_part_does_not_hide_it(shape):
    """Bumps have outliers, ridges are uneven: told from the part of the surface without them."""
    waves = heights(seed=5)
    relief = np.where(waves > 1.2, waves, 0.0) if shape == "bumps" else np.abs(waves)
    has_relief = VERTICES[:, 0] > np.quantile(VERTICES[:, 0], 0.55)
    smooth = found(noisy(0.2, 4) + FRAME.raised(0.6 * np.where(has_relief, relief, 0)))
    assert smooth.is_noise
    assert smooth.level == pytest.approx(0.2, rel=0.15)


def test_white_noise_is_not_smooth():
    for level in (0.05, 0.1, 0.2):
        smooth = found(noisy(level, passes=0))
        assert not smooth.is_noise
        assert not smooth.may_be_noise


def test_little_of_it_is_left_alone():
    assert not found(noisy(0.05)).is_noise


def test_a_bump_here_and_there_is_no_noise():
    """As rough as the noise, but in one quarter of the surface."""
    points = noisy(0.2)
    is_quiet = VERTICES[:, 0] < 1.5
    points[is_quiet] = VERTICES[is_quiet]
    assert not found(points).is_noise
    assert not found(points).is_likely
    assert found(points).level < 0.4 * 0.2


def test_detail_that_is_not_normally_distributed_is_no_noise():
    """As even over the surface and as fine as noise."""
    waves = heights()
    cracks = -np.maximum(np.abs(heights(3)).max() / 8 - np.abs(heights(3)), 0)
    bumps = np.where(waves > np.quantile(waves, 0.97), waves, 0.0)
    for detail in (cracks, bumps):
        relief = found(VERTICES + FRAME.raised(0.2 * detail / detail.std()))
        assert not relief.is_noise
        assert relief.evidence < found(noisy(0.2, 4)).evidence - 0.5


def test_detail_whose_waves_go_on_growing_is_no_noise():
    """A rough rock: waves twice as long are twice as high."""
    rock = sum(2**k * heights(4**k, seed=k) for k in range(4))
    assert found(VERTICES + FRAME.raised(0.1 * rock)).excess > parameters().told_excess
    assert not found(VERTICES + FRAME.raised(0.1 * rock)).is_noise


def test_it_is_removed_and_said_and_kept_when_asked_for():
    points = noisy(0.3)
    removed = denoise(points, FACES)
    assert error(removed.positions) < 0.75 * error(points)
    (note,) = removed.notes
    assert "smooth noise of a scanner" in note
    assert "removed" in note
    kept = denoise(points, FACES, DenoiseSettings(clean="detail"))
    assert not kept.is_changed
    assert "fine detail, which was kept" in kept.notes[0]


def test_noise_of_five_edges_is_found_in_part():
    points = noisy(0.4, passes=24)
    removed = denoise(points, FACES)
    assert error(removed.positions) < 0.9 * error(points)
    assert "removed" in removed.notes[0]
    kept = denoise(points, FACES, DenoiseSettings(clean="detail"))
    assert not kept.is_changed
    assert "fine detail, which was kept" in kept.notes[0]


def test_wider_noise_is_kept():
    kept = denoise(noisy(0.4, passes=48), FACES)
    assert not kept.is_changed
    assert "nothing was changed" in kept.notes[-1]


def error(positions):
    ring = np.hypot(positions[:, 0], positions[:, 1]) - 2
    return np.sqrt(np.mean((np.hypot(ring, positions[:, 2]) - 1) ** 2))


@pytest.mark.parametrize("shape", ["torus", "small torus", "graded sphere", "sphere"])
def test_clean_shapes_are_not_said_to_have_it(shape):
    vertices, faces = {
        "torus": (VERTICES, FACES),
        "small torus": meshes.torus(48, 24),
        "graded sphere": meshes.graded_sphere(4),
        "sphere": meshes.icosphere(5),
    }[shape]
    result = denoise(vertices, faces)
    assert not result.is_changed
    notes = result.notes
    assert not any("scanner" in note for note in notes)


def test_the_result_names_the_other_reading():
    points = noisy(0.2, 4)
    found = {
        clean: denoise(points, FACES, DenoiseSettings(clean=clean)).other_readings
        for clean in ("keep", "detail", "denoise")
    }
    assert found == {"keep": ("detail",), "detail": ("denoise",), "denoise": ()}
    white = VERTICES + FRAME.raised(0.2 * np.random.default_rng(0).normal(size=len(VERTICES)))
    assert denoise(white, FACES).other_readings == ()
