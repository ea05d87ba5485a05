"""`denoise` with weights on a small part of a mesh: what it looks at, and what comes out."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import (
    DenoiseSettings,
    InputError,
    LoopSpace,
    PreparedMesh,
    denoise,
)
from adaptive_fairing.core.denoising import denoise as entry
from adaptive_fairing.core.denoising import whole_run
from adaptive_fairing.core.denoising.denoise import FILTERED
from adaptive_fairing.core.denoising.wide_noise import denoised_surfaces
from adaptive_fairing.core.problem import prepared_surface
from adaptive_fairing.core.problem.problem import Margin

CLEAN, FACES = meshes.torus(130, 60)
EDGE = 2 * np.pi / 60
NOISY = CLEAN + np.random.default_rng(0).normal(0, 0.2 * EDGE, CLEAN.shape)
PLACE = 20 * 60  # on the outer side
DISTANCE = np.linalg.norm(CLEAN - CLEAN[PLACE], axis=1)
WEIGHTS = (DISTANCE < 12 * EDGE).astype(float)


def roughness(positions):
    """Root mean square of the distance to the torus, where the weights are 1."""
    x, y, z = positions[WEIGHTS > 0].T
    return np.sqrt(np.mean((np.hypot(np.hypot(x, y) - 2, z) - 1) ** 2))


@pytest.fixture(scope="module")
def whole():
    prepared = PreparedMesh(NOISY, FACES)
    return prepared, denoise(NOISY, FACES, prepared=prepared)


@pytest.fixture
def seen(monkeypatch):
    """Numbers of triangles of all surfaces that are filtered."""
    numbers = []

    def counted(topology, *given, **options):
        numbers.append(topology.n_triangles)
        return denoised_surfaces(topology, *given, **options)

    for module in (entry, whole_run):
        monkeypatch.setattr(module, "denoised_surfaces", counted)
    return numbers


def part_triangles():
    """Count the triangles around the vertices of fewer rings than are filtered on."""
    reached = WEIGHTS > 0
    for _ in range(FILTERED.n_rings - 1):
        reached[FACES[reached[FACES].any(axis=1)]] = True
    return np.count_nonzero(reached[FACES].any(axis=1))


def largest_difference(shapes, expected):
    """Largest difference, over the root mean square of what is removed where anything is."""
    removed = expected - NOISY
    return np.abs(shapes - expected).max() / np.sqrt(np.mean(removed[removed != 0] ** 2))


def test_a_part_goes_where_the_whole_goes(whole):
    soft = np.where(DISTANCE < 6 * EDGE, 1, 0.5) * WEIGHTS
    result = denoise(NOISY, FACES, weights=soft)
    expected = NOISY + soft[:, None] * (whole[1].shapes - NOISY)
    assert np.array_equal(result.shapes[:, soft == 0], expected[:, soft == 0])
    assert largest_difference(result.shapes, expected) < 1e-6
    assert np.array_equal(result.noise[soft > 0], whole[1].noise[soft > 0])
    assert not result.noise[DISTANCE > 40 * EDGE].any()
    assert result.radius == whole[1].radius


def test_press_after_press_makes_the_whole(whole, seen):
    """Overlapping parts, kept in single precision, each from where the last has left the mesh."""
    prepared, positions = PreparedMesh(NOISY, FACES), NOISY
    is_there = np.zeros(len(NOISY), dtype=bool)
    for distance in (0, 8, 16):
        middle = np.roll(CLEAN, -distance * 60, axis=0)[PLACE]
        weights = np.linalg.norm(CLEAN - middle, axis=1) < 12 * EDGE
        is_there |= weights
        result = denoise(positions, FACES, weights=weights, prepared=prepared)
        positions = result.positions.astype(np.float32).astype(float)
        positions[~is_there] = NOISY[~is_there]
    assert seen == [len(FACES)]
    assert (
        largest_difference(positions, np.where(is_there[:, None], whole[1].positions, NOISY)) < 1e-5
    )
    denoise(NOISY, FACES, DenoiseSettings(strength=0.5), weights=weights, prepared=prepared)
    assert seen == 2 * [len(FACES)]


def test_noise_is_judged_from_the_part_alone(whole):
    """Neighbours that an earlier run has denoised do not make it think that there is none."""
    expected = denoise(NOISY, FACES, weights=WEIGHTS)
    after = np.where(WEIGHTS[:, None] > 0, NOISY, whole[1].positions)
    result = denoise(after, FACES, weights=WEIGHTS)
    # A median of n values is wrong by 1.167 / √n, and three vertices say as much as one value.
    error = 1.167 * np.sqrt(3 / np.count_nonzero(WEIGHTS))
    assert result.noise_level == pytest.approx(expected.noise_level, rel=error)
    assert roughness(result.positions) < 1.25 * roughness(expected.positions)


def test_a_part_that_is_noisier_than_the_rest_is_judged_by_itself(whole):
    mixed = CLEAN + np.where(WEIGHTS[:, None] > 0, 1, 0.4) * (NOISY - CLEAN)
    result = denoise(mixed, FACES, weights=WEIGHTS)
    assert result.noise_level == pytest.approx(whole[1].noise_level, rel=0.2)
    assert roughness(result.positions) < 1.25 * roughness(whole[1].positions)


def test_the_plan_of_the_whole_serves_its_parts(whole, monkeypatch):
    prepared, planned = whole
    expected = np.where(WEIGHTS[:, None] > 0, planned.positions, NOISY)
    removed = np.linalg.norm(expected - NOISY)

    def difference():
        result = denoise(NOISY, FACES, weights=WEIGHTS, prepared=prepared, plan=planned.plan)
        return np.linalg.norm(result.positions - expected) / removed

    assert difference() < 0.05
    with monkeypatch.context() as narrow:
        narrow.setattr(entry, "FILTERED_AS_PLANNED", Margin(1))
        assert difference() > 0.05


def test_an_edited_place_is_judged_by_itself(seen):
    """Elsewhere the run on the whole still holds."""
    prepared = PreparedMesh(NOISY, FACES)
    first = denoise(NOISY, FACES, weights=WEIGHTS, prepared=prepared)
    edited = NOISY.copy()
    edited[PLACE] += 0.3 * EDGE
    here = denoise(edited, FACES, weights=WEIGHTS, prepared=prepared)
    assert seen == [len(FACES), part_triangles()]
    assert part_triangles() < len(FACES) / 4
    assert 0 < largest_difference(here.shapes, first.shapes)
    away = np.roll(WEIGHTS, 60 * 60)
    assert np.array_equal(
        denoise(edited, FACES, weights=away, prepared=prepared).positions[away > 0],
        denoise(NOISY, FACES, weights=away, prepared=prepared).positions[away > 0],
    )
    assert len(seen) == 2


def test_a_surface_that_is_too_large_is_filtered_around_the_part_alone(seen, monkeypatch):
    monkeypatch.setattr(whole_run, "LARGEST_WHOLE", len(FACES) - 1)
    result = denoise(NOISY, FACES, weights=WEIGHTS)
    assert seen == [part_triangles()]
    assert roughness(result.positions) < 0.5 * roughness(NOISY)
    with pytest.raises(InputError, match=f"plan is of a mesh of {len(result.plan.noise)} vertices"):
        denoise(NOISY, FACES, weights=WEIGHTS, plan=result.plan)


def test_a_second_run_prepares_nothing(monkeypatch):
    made = []
    monkeypatch.setattr(
        prepared_surface, "LoopSpace", lambda *given: made.append(1) or LoopSpace(*given)
    )
    prepared = PreparedMesh(NOISY, FACES)
    first = denoise(NOISY, FACES, weights=WEIGHTS, prepared=prepared)
    again = denoise(NOISY, FACES, weights=WEIGHTS, prepared=prepared)
    assert len(made) == 1
    assert np.array_equal(first.positions, again.positions)


def test_the_plan_of_a_run_on_a_part_is_that_of_the_whole(whole):
    plan = denoise(NOISY, FACES, weights=WEIGHTS, prepared=whole[0]).plan
    assert np.array_equal(plan.noise, whole[1].plan.noise)
    result = denoise(NOISY, FACES, weights=WEIGHTS, prepared=whole[0], plan=plan)
    assert np.array_equal(result.plan.noise, plan.noise)


@pytest.mark.parametrize("noise", [0.03, 0.15])
def test_the_plan_of_the_whole_serves_a_quiet_piece(noise):
    """The filters are those for the loud one beside it; of very little noise none are mixed."""
    quiet, faces = meshes.torus(60, 30)
    loud, others = meshes.torus(80, 40)
    is_quiet = np.repeat([True, False], [len(quiet), len(loud)])
    size = EDGE * np.where(is_quiet, 2 * noise, 0.6)
    directions = np.random.default_rng(0).normal(size=(len(size), 3))
    noisy = np.vstack([quiet, loud + np.array([8, 0, 0])]) + size[:, None] * directions
    triangles = np.vstack([faces, others + len(quiet)])
    prepared = PreparedMesh(noisy, triangles)
    whole = denoise(noisy, triangles, prepared=prepared)
    weights = is_quiet.astype(float)
    part = denoise(noisy, triangles, weights=weights, prepared=prepared, plan=whole.plan)
    removed = np.linalg.norm((whole.positions - noisy)[is_quiet])
    assert (removed > 0) == (noise > 0.1)
    assert np.linalg.norm((part.positions - whole.positions)[is_quiet]) <= 0.03 * removed
