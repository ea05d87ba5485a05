"""Verdict on the noise of a surface: of which kind it is, how much, and what is said of it."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising import mesh_parts
from adaptive_fairing.core.denoising import noise_verdict as verdicts
from adaptive_fairing.core.denoising.noise_verdict import (
    IMPULSIVE,
    SMOOTH,
    SMOOTH_REMOVED,
    noise_verdict,
)
from adaptive_fairing.core.denoising.stage import Stage
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

VERTICES, FACES = meshes.torus(100, 50)
TOPOLOGY = TriangleTopology(FACES, len(VERTICES))
CLEAN = TriangleSurface(TOPOLOGY, VERTICES)
WHITE = np.random.default_rng(0).normal(size=len(VERTICES))


def stage_of(heights):
    """Stage of the torus with heights (n,) in local edge lengths."""
    still = np.zeros(len(VERTICES), dtype=bool)
    return Stage(TOPOLOGY, VERTICES + CLEAN.raised(heights), still, lambda report: None)


def smooth(level, passes=4):
    heights = CLEAN.spread(WHITE, passes)
    return level * heights / heights.std()


def spikes(size, part=0.1):
    generator = np.random.default_rng(1)
    return np.where(generator.random(len(VERTICES)) < part, size * WHITE, 0)


@pytest.mark.parametrize("clean", ["keep", "detail", "denoise"])
def test_white_noise_has_its_level_and_is_removed_whatever_is_kept(clean):
    verdict = noise_verdict(stage_of(0.2 * WHITE), clean)
    assert np.median(verdict.level) == pytest.approx(0.2, rel=0.1)
    assert np.array_equal(verdict.reach, verdict.level)
    assert verdict.smooth is None
    assert (verdict.correlation.coefficient, verdict.correlation.passes) == (0, 0)
    assert (verdict.notes, verdict.other_readings) == ((), ())
    assert not verdict.impulsive.any()


@pytest.mark.parametrize("heights", [0.2 * WHITE, smooth(0.2)])
def test_its_examples_are_as_strong_as_the_whole_noise(heights):
    verdict = noise_verdict(stage_of(heights), "keep")
    judged = verdict.level > 0
    for example in verdict.examples():
        ratio = example[judged] / verdict.whole(verdict.level)[judged]
        assert np.std(ratio) == pytest.approx(1, rel=0.1)


def test_smooth_noise_is_removed_and_may_be_kept_as_detail():
    stage = stage_of(smooth(0.2))
    removed, kept, forced = (noise_verdict(stage, clean) for clean in ("keep", "detail", "denoise"))
    for verdict in (removed, forced):
        assert np.median(verdict.level) == pytest.approx(0.2, rel=0.5)
        assert verdict.correlation is verdict.smooth
        assert verdict.smooth.passes > 1
        # Differences of second order hardly show it, so the level is already that of all.
        assert verdict.notes == (SMOOTH_REMOVED.format(verdict.level[0]),)
    assert (removed.other_readings, forced.other_readings) == (("detail",), ())
    assert kept.smooth is None
    assert not kept.level.any()
    assert kept.notes[0].startswith(SMOOTH.partition("{")[0])
    assert kept.other_readings == ("denoise",)


def test_spikes_are_put_back_first():
    stage = stage_of(spikes(0.6) + 0.02 * np.roll(WHITE, 7))
    verdict = noise_verdict(stage, "keep")
    assert verdict.notes == (IMPULSIVE,)
    assert verdict.impulsive.max() == 1
    assert verdict.stage is not stage
    left = [
        np.sqrt(np.mean(CLEAN.along_normal(each.noisy.positions - VERTICES) ** 2))
        for each in (stage, verdict.stage)
    ]
    assert left[1] < 0.5 * left[0]
    assert (verdict.reach >= verdict.level).all()


def test_spikes_of_the_shape_do_not_choose_the_level(monkeypatch):
    """Which vertices stood out depends on rounding, and what is rough without them as well."""
    monkeypatch.setattr(verdicts, "_noisy_spikes", lambda *found: np.zeros(len(VERTICES), bool))
    stage = stage_of(spikes(0.6) + 0.1 * np.roll(WHITE, 7))
    verdict = noise_verdict(stage, "keep")
    found, calm = stage.parts.noise(stage.noisy), stage.calmed(np.ones(len(VERTICES), bool))
    after = calm.parts.noise(calm.noisy)
    assert found.impulsive.any()
    assert not verdict.impulsive.any()
    assert np.median(found.level) > 1.02 * np.median(after.level) > 0
    assert np.array_equal(verdict.level, found.level)


def test_the_tails_of_normal_noise_are_no_spikes(monkeypatch):
    """Some vertices stand out, too; to put them back would make the rest another noise."""
    monkeypatch.setattr(mesh_parts, "is_impulsive", lambda *surface: True)
    stage = stage_of(0.2 * WHITE)
    verdict = noise_verdict(stage, "keep")
    calm = stage.calmed(np.ones(len(VERTICES), bool))
    assert (calm.noisy.positions != stage.noisy.positions).any()
    assert not verdict.impulsive.any()
    assert verdict.notes == ()
    assert np.array_equal(verdict.level, stage.parts.noise(stage.noisy).level)
    # With as many spikes as noise has vertices in its tails, it has more than them.
    verdict = noise_verdict(stage_of(0.2 * WHITE + spikes(1.0, 0.02)), "keep")
    assert verdict.impulsive.any()
    assert verdict.notes == (IMPULSIVE,)


def test_below_spikes_smooth_noise_is_found_as_well():
    stage = stage_of(smooth(0.2) + spikes(1.5))
    verdict = noise_verdict(stage, "keep")
    assert verdict.impulsive.any()
    assert verdict.smooth.passes > 1
    assert np.median(verdict.level) == pytest.approx(0.2, rel=0.5)
    assert verdict.notes == (IMPULSIVE, SMOOTH_REMOVED.format(verdict.level[0]))
    assert verdict.other_readings == ("detail",)


def test_a_clean_surface_has_none_and_says_so():
    verdict = noise_verdict(stage_of(0 * WHITE), "keep")
    assert not verdict.level.any()
    assert "no noise found" in verdict.notes[-1]
    assert verdict.other_readings in ((), ("denoise",))


def test_examples_of_the_noise_are_as_large_as_the_whole_noise():
    verdict = noise_verdict(stage_of(0.2 * WHITE), "keep")
    whole = verdict.whole(verdict.level)
    assert np.median(whole) == pytest.approx(0.2, rel=0.1)
    examples = verdict.examples()
    np.testing.assert_allclose(np.std(examples / whole, axis=1), 1, rtol=0.05)
    assert np.abs(np.corrcoef(examples) - np.eye(len(examples))).max() < 4 / np.sqrt(len(whole))
