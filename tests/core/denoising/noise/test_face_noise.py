"""Smooth noise on flat faces: its level, its correlation, and texture that is none."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.flat_faces import NO_FACE, FlatFaces
from adaptive_fairing.core.denoising.noise.face_noise import face_noise
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.noise.smooth_noise import SmoothNoise, with_presence
from adaptive_fairing.core.denoising.noise_model import NoiseCorrelation
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

CUBE, FACES = meshes.cube(5, unevenness=0.2)
TOPOLOGY = TriangleTopology(FACES, len(CUBE))
CLEAN = TriangleSurface(TOPOLOGY, CUBE)
ON_FACE = np.isclose(np.abs(CUBE), 1)
ASSUMED = NoiseCorrelation(deviation=0.19, passes=PARAMETERS.assumed_passes)
EVERYWHERE = np.ones(len(CUBE), dtype=bool)


def smooth(passes, seed=0):
    """Noise of unit size, (n,)."""
    heights = CLEAN.spread(np.random.default_rng(seed).normal(size=len(CUBE)), passes)
    return heights / heights.std()


def with_heights(heights):
    return CUBE + CLEAN.raised(heights)


def found(points):
    surface = TriangleSurface(TOPOLOGY, points)
    slightly_smoothed = TriangleSurface(TOPOLOGY, CLEAN.spread(points, 1))
    faces = FlatFaces(slightly_smoothed, points, correlation=ASSUMED)
    noisy = NoisySurface(points, slightly_smoothed.with_frame(spacing=surface.spacing))
    return face_noise(noisy, faces, EVERYWHERE)


@pytest.mark.parametrize("passes", [3, 4, 8])
@pytest.mark.parametrize("level", [0.1, 0.2, 0.3])
def test_level_and_correlation_are_right(level, passes):
    """The level has the error of the noise itself: each face has few independent values."""
    noise = found(with_heights(level * smooth(passes)))
    assert noise.is_noise
    # Nearly all vertices are well inside the faces.
    n_independent = 0.8 * len(CUBE) * noise.correlation.deviation**2
    assert noise.level == pytest.approx(level, rel=0.05 + 2 / np.sqrt(2 * n_independent))
    assert passes / 1.6 <= noise.correlation.passes <= 1.6 * passes


def test_what_planes_take_of_wide_noise_is_put_back():
    """In the mean of eight; without it the level is lower by more than this tolerance."""
    levels = [found(with_heights(0.2 * smooth(8, seed))).level / 0.2 for seed in range(8)]
    assert np.mean(levels) == pytest.approx(1, abs=3 * np.std(levels) / np.sqrt(8))


def test_faces_of_vertices_are_the_sides_of_the_cube():
    points = with_heights(0.2 * smooth(4))
    surface = TriangleSurface(TOPOLOGY, CLEAN.spread(points, 1))
    faces = FlatFaces(surface, points, correlation=ASSUMED)
    face = faces.of_vertices()
    sides = np.sign(CUBE) * ON_FACE
    for number in np.unique(face[face != NO_FACE]):
        assert len(np.unique(sides[face == number], axis=0)) == 1
    # All but the ring beside the creases.
    assert np.mean(face != NO_FACE) > 0.8
    assert not np.any(ON_FACE.sum(axis=1)[face != NO_FACE] > 1)


@pytest.mark.parametrize("points", [CUBE, meshes.icosphere(5)[0]], ids=["clean cube", "round"])
def test_clean_shapes_have_none(points):
    if points is not CUBE:
        result = denoise(*meshes.icosphere(5))
    else:
        assert found(CUBE).level < 1e-6
        result = denoise(CUBE, FACES)
    assert not result.is_changed
    assert not any("scanner" in note for note in result.notes)


def test_white_noise_is_not_smooth():
    assert found(with_heights(0.1 * smooth(0))).correlation.passes == 0
    assert not found(with_heights(0.1 * smooth(0))).may_be_noise


def test_texture_is_no_noise():
    """Pits are not normally distributed, ridges have one width, patches are not even."""
    x, y, z = CUBE.T * 2**4
    pits = -np.exp(-np.square(np.minimum(smooth(3), 0) + 2))
    ridges = np.sin(np.pi * (x + y + z) / 4)
    patches = smooth(4) * (x > 0)
    for texture in (pits, ridges, patches):
        noise = found(with_heights(0.3 * texture / texture.std()))
        assert not noise.is_noise


TOLD = SmoothNoise(
    level=0.2,
    correlation=NoiseCorrelation(seen=0.3, deviation=0.3, passes=4),
    misfit=0.02,
    evenness=0.9,
    outliers=1.1,
    lean=0.01,
    is_enough=True,
)


@pytest.mark.parametrize(
    "wrong",
    [
        {"level": 0.03},
        {"is_enough": False},
        {"correlation": NoiseCorrelation(passes=1)},
        {"misfit": 2.0},
        {"evenness": 0.5},
        {"outliers": 1.7},
        {"lean": 0.2},
    ],
)
def test_all_conditions_must_hold(wrong):
    assert TOLD.is_noise
    assert not TOLD._replace(**wrong).is_noise


def test_noise_is_everywhere():
    """Bends of thin walls are on what counts as faces there, and hardly anywhere else."""
    points = with_heights(0.2 * smooth(4))
    noise = found(points)
    assert noise.is_noise
    assert noise.presence > 1.1 * PARAMETERS.least_presence
    # Half of the cube is as it was, faces and hinges.
    is_clean = CUBE.sum(axis=1) > 0
    halved = np.where(is_clean[:, None], CUBE, points)
    surface = TriangleSurface(TOPOLOGY, CLEAN.spread(halved, 1))
    asked = with_presence(noise._replace(presence=1.0), NoisySurface(halved, surface), EVERYWHERE)
    assert asked.presence < 0.2
    assert not asked.is_noise


@pytest.mark.parametrize("passes, left", [(4, 0.35), (12, 0.6)])
def test_it_is_removed_and_faces_come_out_flat(passes, left):
    """Over four edges, which is told from shape nowhere else, as well as over two."""
    points = with_heights(0.3 * smooth(passes))
    result = denoise(points, FACES)
    assert "removed" in result.notes[0]
    assert result.other_readings == ("detail",)

    def off_the_cube(positions):
        return np.sqrt(np.mean(np.where(ON_FACE, np.abs(positions) - 1, 0) ** 2))

    assert off_the_cube(result.positions) < left * off_the_cube(points)
    again = denoise(points, FACES, plan=result.plan)
    assert np.array_equal(again.positions, result.positions)
    assert not denoise(points, FACES, DenoiseSettings(clean="detail")).is_changed
