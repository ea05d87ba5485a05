"""Noise that is alike over several edges: what can be told, and that the user decides."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoise.local_frame import LocalFrame
from adaptive_fairing.core.denoise.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoise.noise.smooth_noise import smooth_noise

VERTICES, FACES = meshes.torus(104, 52)
TOPOLOGY = TriangleTopology(FACES, len(VERTICES))
FRAME = LocalFrame.of(TOPOLOGY, VERTICES, VERTICES)


def noisy(level, passes=8, seed=0):
    heights = FRAME.spread(np.random.default_rng(seed).normal(size=len(VERTICES)), passes)
    return VERTICES + FRAME.raised(level * heights / heights.std())


def found(points):
    everywhere = np.ones(len(points), dtype=bool)
    return smooth_noise(NoisySurface(TOPOLOGY, points, FRAME), everywhere)


@pytest.mark.parametrize("level", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("passes", [4, 8])
def test_it_is_even_and_its_level_is_about_right(level, passes):
    smooth = found(noisy(level, passes))
    assert smooth.may_be_noise
    assert 0.5 * level < smooth.level < 1.6 * level
    assert smooth.correlation.passes in (4, 8, 16)


def test_a_bump_here_and_there_is_no_noise():
    """As rough as the noise, but in one quarter of the surface."""
    points = noisy(0.2)
    is_quiet = VERTICES[:, 0] < 1.5
    points[is_quiet] = VERTICES[is_quiet]
    assert not found(points).is_likely
    assert found(points).level < 0.4 * 0.2


def test_it_is_kept_and_mentioned_and_removed_when_asked_for():
    points = noisy(0.3)
    kept = denoise(points, FACES)
    assert not kept.is_changed
    assert "the smooth noise of a scanner" in kept.notes[0]
    assert "nothing was changed" in kept.notes[-1]
    removed = denoise(points, FACES, DenoiseSettings(clean="denoise"))

    def error(positions):
        ring = np.hypot(positions[:, 0], positions[:, 1]) - 2
        return np.sqrt(np.mean((np.hypot(ring, positions[:, 2]) - 1) ** 2))

    assert error(removed.positions) < 0.75 * error(points)


@pytest.mark.parametrize("shape", ["torus", "small torus", "graded sphere", "sphere"])
def test_clean_shapes_are_not_said_to_have_it(shape):
    vertices, faces = {
        "torus": (VERTICES, FACES),
        "small torus": meshes.torus(48, 24),
        "graded sphere": meshes.graded_sphere(4),
        "sphere": meshes.icosphere(5),
    }[shape]
    notes = denoise(vertices, faces).notes
    assert not any("scanner" in note for note in notes)
