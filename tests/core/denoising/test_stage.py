"""Stage of a run: spikes put back in places, and filters that are repeated."""

import numpy as np
from support import meshes

from adaptive_fairing.core import TriangleTopology, denoise
from adaptive_fairing.core.denoising.noise.spikes import without_spikes
from adaptive_fairing.core.denoising.progress import ProgressReport
from adaptive_fairing.core.denoising.stage import Stage

SPHERE, FACES = meshes.icosphere(3)


def staged(points, faces):
    still = np.zeros(len(points), dtype=bool)
    return Stage(TriangleTopology(faces, len(points)), points, still, lambda report: None)


def with_spikes(vertices, size, below=0.0, seed=0):
    """Every tenth vertex is moved by some lengths along a random direction."""
    generator = np.random.default_rng(seed)
    is_spike = generator.random(len(vertices)) < 0.1
    scale = np.where(is_spike, size, below)[:, None]
    return vertices + scale * generator.normal(size=vertices.shape)


def test_spikes_go_back_where_it_is_asked_for():
    points = with_spikes(SPHERE, 0.1, 0.002)
    stage = staged(points, FACES)
    counted, movable = stage.parts.is_counted, stage.parts.may_move
    back, _ = without_spikes(stage.noisy, counted, movable)
    assert np.abs(back - points).max() > 0.1
    is_above = SPHERE[:, 2] > 0
    calm = stage.calmed(is_above).noisy.positions
    assert np.array_equal(calm, np.where(is_above[:, None], back, points))


def test_a_repeated_track_takes_what_the_first_run_took():
    points = SPHERE + np.random.default_rng(0).normal(0, 0.03, SPHERE.shape)
    plan = denoise(points, FACES).plan
    tracks = [staged(points, FACES).track for _ in range(2)]
    for track in tracks:
        track.repeat(plan, ProgressReport(None, has_plan=True))
    first, second = tracks
    assert tuple(first.taken) == plan.filters
    for each in plan.filters:
        assert np.array_equal(first.taken[each], second.taken[each])
    for mixture in plan.mixtures:
        expected = points.copy()
        for index, taken in enumerate(first.taken.values()):
            expected -= mixture.coefficients(index)[:, None] * taken
        np.testing.assert_allclose(first.mixed(mixture), expected, rtol=0, atol=1e-7)
