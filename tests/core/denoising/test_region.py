"""`denoise` with weights on a small part of a mesh: what it looks at, and what comes out."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import InputError, LoopSpace, PreparedMesh, denoise
from adaptive_fairing.core.denoising import denoise as entry
from adaptive_fairing.core.denoising.denoise import FILTERED
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


def test_the_part_is_denoised_as_well_as_the_whole(whole):
    result = denoise(NOISY, FACES, weights=WEIGHTS)
    assert np.array_equal(result.positions[WEIGHTS == 0], NOISY[WEIGHTS == 0])
    assert result.shapes.shape == (5, len(NOISY), 3)
    assert result.noise_level == pytest.approx(whole[1].noise_level, rel=0.15)
    assert roughness(result.positions) < 1.25 * roughness(whole[1].positions)
    assert roughness(result.positions) < 0.5 * roughness(NOISY)
    assert not result.noise[DISTANCE > 40 * EDGE].any()


def test_noise_is_judged_from_the_part_alone(whole):
    """Neighbours that an earlier run has denoised do not make it think that there is none."""
    expected = denoise(NOISY, FACES, weights=WEIGHTS)
    after = np.where(WEIGHTS[:, None] > 0, NOISY, whole[1].positions)
    result = denoise(after, FACES, weights=WEIGHTS)
    assert result.noise_level == pytest.approx(expected.noise_level, rel=0.08)
    assert roughness(result.positions) < 1.25 * roughness(expected.positions)


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


def test_the_work_is_that_of_the_part(monkeypatch):
    """Triangles around the vertices of fewer rings than are filtered on, counted otherwise."""
    seen, denoised_surfaces = [], entry.denoised_surfaces

    def counted(topology, *given, **options):
        seen.append(topology.n_triangles)
        return denoised_surfaces(topology, *given, **options)

    monkeypatch.setattr(entry, "denoised_surfaces", counted)
    denoise(NOISY, FACES, weights=WEIGHTS)
    reached = WEIGHTS > 0
    for _ in range(FILTERED.n_rings - 1):
        reached[FACES[reached[FACES].any(axis=1)]] = True
    assert seen == [np.count_nonzero(reached[FACES].any(axis=1))]
    assert seen[0] < len(FACES) / 4


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


def test_a_plan_of_a_part_is_refused():
    plan = denoise(NOISY, FACES, weights=WEIGHTS).plan
    with pytest.raises(InputError, match=f"plan is of a mesh of {len(plan.noise)} vertices"):
        denoise(NOISY, FACES, weights=WEIGHTS, plan=plan)


@pytest.mark.parametrize("noise", [0.05, 0.15])
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
