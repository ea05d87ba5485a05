"""Connected parts with noise estimates of their own, and small ones judged together."""

from dataclasses import replace

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.mesh_parts import MeshParts, density_classes
from adaptive_fairing.core.denoising.mixing import IN_DOUBT, LIKE_DETAIL, UNLIKE_NOISE
from adaptive_fairing.core.denoising.noise import noisy_surface
from adaptive_fairing.core.denoising.noise.clean_detail import CleanDetail
from adaptive_fairing.core.denoising.noise.contrast import LineRoughness
from adaptive_fairing.core.denoising.noise.level import variance_law
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.parameters import PARAMETERS, using
from adaptive_fairing.core.denoising.stage import Stage
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

BALL, FACES = meshes.icosphere(3)
SMALL_BALL, SMALL_FACES = meshes.icosphere(2)


def noisy(clean, faces, level, seed=0):
    """Noise along the normals of a ball about the origin, in local edge lengths."""
    spacing = TriangleSurface(TriangleTopology(faces, len(clean)), clean).spacing
    heights = level * spacing * np.random.default_rng(seed).normal(size=len(clean))
    return clean * (1 + heights[:, None])


def side_by_side(*parts):
    return meshes.merged(*((points + 9 * k, faces) for k, (points, faces) in enumerate(parts)))


def stage_of(points, faces):
    topology = TriangleTopology(faces, len(points))
    return Stage(topology, points, np.zeros(len(points), dtype=bool), lambda report: None)


def found_in(points, faces):
    stage = stage_of(points, faces)
    return stage.parts.noise(stage.noisy)


def levels_of(points, faces):
    """Noise that is found, (n,)."""
    return found_in(points, faces).level


def even_levels_of(points, faces):
    """Noise that is found, (n,), without its unevenness."""
    found = found_in(points, faces)
    return found.level if found.unevenness is None else found.level / found.unevenness


def test_large_parts_have_estimates_of_their_own():
    parts = [(noisy(BALL, FACES, level, seed), FACES) for seed, level in enumerate((0.1, 0.3))]
    level = levels_of(*side_by_side(*parts))
    first, second = level[: len(BALL)], level[len(BALL) :]
    assert np.median(first) == pytest.approx(0.1, rel=0.2)
    assert np.median(second) == pytest.approx(0.3, rel=0.2)


def test_a_clean_part_stays_clean_beside_a_noisy_one():
    points, faces = side_by_side((BALL, FACES), (noisy(BALL, FACES, 0.2), FACES))
    moves = np.linalg.norm(denoise(points, faces).positions - points, axis=1)
    assert moves[: len(BALL)].max() < 1e-3 * moves[len(BALL) :].max()
    assert moves[len(BALL) :].max() > 0


def bounds_of(points, faces):
    """Levels (n,) by roughness and by hinges at the inner vertices, and those, (n,) bool.

    Hinges must be lower by more than chance, and tell nothing of noise over 0.25.
    """
    stage = stage_of(points, faces)
    surface, counted = stage.noisy, stage.parts.is_counted
    laws = (variance_law(each, counted) for each in (surface.roughness, surface.hinges))
    rough, hinged = (law.level(surface.frame.spacing) for law in laws)
    bound = (1 + 1.167 / np.sqrt(np.count_nonzero(counted))) * hinged
    return rough, np.where(hinged > 0.25, np.inf, bound), counted


def test_at_every_vertex_the_lower_bound_counts():
    """Roughness and hinges see the same noise; shape adds more to the one here, the other there."""
    vertices, faces = meshes.graded_sphere(4)
    frame = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    length = 0.2 * np.median(frame.spacing)
    heights = length / frame.spacing * np.random.default_rng(2).normal(size=len(vertices))
    points = vertices + frame.raised(heights)
    rough, hinged, counted = bounds_of(points, faces)
    assert np.any(rough < hinged) and np.any(hinged < rough)
    level, least = even_levels_of(points, faces), np.minimum(rough, hinged)
    np.testing.assert_allclose(level[counted], least[counted], rtol=1e-3)


def test_grooves_on_a_part_of_a_mesh_do_not_raise_its_noise():
    """The law of the roughness has no places, so they raise all of it; hinges do not see them."""
    grid, faces = meshes.flat_grid(80, 60)
    column = grid[:, 0]
    clean = grid + np.where(column < 26, np.abs(column % 8 - 4), 0)[:, None] * [0, 0, 1]
    frame = TriangleSurface(TriangleTopology(faces, len(clean)), clean)
    points = clean + frame.raised(0.1 * np.random.default_rng(0).normal(size=len(clean)))
    found = even_levels_of(points, faces)
    assert np.median(found[found > 0]) == pytest.approx(0.1, rel=0.03)


def test_small_parts_are_judged_together():
    """One level for all of them, where each alone would be judged by its own.

    How uneven it is besides is told around every vertex.
    """
    parts = [
        (noisy(SMALL_BALL, SMALL_FACES, level, seed), SMALL_FACES)
        for seed, level in enumerate((0.15, 0.4, 0.15, 0.4))
    ]
    n = len(SMALL_BALL)
    assert n < PARAMETERS.fewest_to_tell <= len(BALL)
    points, faces = side_by_side(*parts)

    def contrast():
        level = even_levels_of(points, faces).reshape(-1, n)
        of_part = np.median(level, axis=1)
        return of_part[[1, 3]].mean() / of_part[[0, 2]].mean()

    assert contrast() == pytest.approx(1, abs=0.1)
    with using(replace(PARAMETERS, fewest_to_tell=n)):
        assert contrast() > 1.8


def test_what_all_parts_are_judged_by_is_computed_once(monkeypatch):
    made = []
    monkeypatch.setattr(
        noisy_surface, "LineRoughness", lambda *args: made.append(LineRoughness(*args)) or made[-1]
    )
    parts = [(noisy(BALL, FACES, 0.2, seed), FACES) for seed in range(3)]
    level = levels_of(*side_by_side(*parts)).reshape(3, -1)
    assert np.median(level, axis=1) == pytest.approx(0.2, rel=0.2)
    assert len(made) == 1


def test_filters_are_chosen_in_every_part_by_its_noise():
    """What a filter removes is the noise itself: its coefficient is 1 where there is noise."""
    points, faces = side_by_side((BALL, FACES), (BALL, FACES))
    topology = TriangleTopology(faces, len(points))
    frame = TriangleSurface(topology, points)
    parts = MeshParts(frame, np.zeros(len(points), dtype=bool))
    removed = np.random.default_rng(0).normal(size=(1, len(points)))
    variances = np.where(np.arange(len(points)) < len(BALL), 1.0, 0.0)[None]
    (mixture,) = parts.best_mixtures(removed, np.ones_like(removed), variances)
    chosen = mixture.coefficients(0)
    assert chosen[: len(BALL)].mean() == pytest.approx(1, abs=0.1)
    assert not chosen[len(BALL) :].any()


def test_classes_add_up_to_one_and_follow_the_density():
    size = np.random.default_rng(4).normal(size=4000)
    classes = density_classes(size, np.ones(4000, dtype=bool))
    assert len(classes) == 3
    np.testing.assert_allclose(classes.sum(axis=0), 1)
    assert classes[:, size.argmin()].tolist() == [1, 0, 0]
    assert classes[:, size.argmax()].tolist() == [0, 0, 1]


def test_an_even_mesh_is_one_class():
    everyone = np.ones(4000, dtype=bool)
    assert len(density_classes(np.zeros(4000), everyone)) == 1
    assert len(density_classes(np.linspace(0, 1, 50), everyone[:50])) == 1


def test_specks_of_few_vertices_stay_as_they_are():
    """What would tell their noise from their shape takes more of them."""
    speck, speck_faces = meshes.icosahedron()
    rough = speck * (1 + 0.3 * np.random.default_rng(0).normal(size=(len(speck), 1)))
    points, faces = side_by_side((noisy(BALL, FACES, 0.2), FACES), (rough, speck_faces))
    moved = (denoise(points, faces).positions != points).any(axis=1)
    assert moved[: len(BALL)].mean() > 0.9
    assert not moved[len(BALL) :].any()


@pytest.fixture(scope="module")
def two_balls():
    """Two parts of one mesh, with a noisy surface of each."""
    points, faces = side_by_side((BALL, FACES), (BALL, FACES))
    surface = TriangleSurface(TriangleTopology(faces, len(points)), points)
    return surface, MeshParts(surface, np.zeros(len(points), dtype=bool))


def test_noise_that_is_removed_does_not_come_in_clusters(two_balls):
    """What is removed of a shape does, also by much smaller amounts; each part by itself."""
    surface, parts = two_balls
    n = len(BALL)
    numbers = np.random.default_rng(3).normal(size=2 * n)
    near_edge = np.exp(-((np.tile(BALL[:, 0], 2) / 0.3) ** 2))
    shape = np.where(np.arange(2 * n) < n, 1, 3 * near_edge) * numbers
    for size in (0.05, 0.3):
        after = TriangleSurface(surface.topology, surface.positions - surface.raised(size * shape))
        noise, corners = parts.clustering(surface, after, np.full(2 * n, size))
        assert abs(noise) < 4 / np.sqrt(n)
        assert corners > PARAMETERS.most_clustered


def test_noise_that_is_removed_is_independent_of_the_shape():
    """What is removed of a shape follows the bending that stays; each part by itself."""
    ball, faces = meshes.icosphere(4)
    n = len(ball)
    bumpy = ball * (1 + 0.1 * np.sin(5 * ball).sum(axis=1, keepdims=True))
    points, faces = side_by_side((bumpy, faces), (bumpy, faces))
    surface = TriangleSurface(TriangleTopology(faces, len(points)), points)
    parts = MeshParts(surface, np.zeros(len(points), dtype=bool))
    numbers = np.random.default_rng(3).normal(size=2 * n)
    bending = surface.mean @ surface.rises(points)
    bending = (bending - bending.mean()) / bending.std()
    # A third of what goes is shape, in the second part.
    ways = np.where(np.arange(2 * n) < n, numbers, numbers + np.sqrt(0.5) * bending)
    for size in (0.02, 0.2):
        before = TriangleSurface(surface.topology, points + surface.raised(size * ways))
        noise, shape = parts.likeness(before, surface, np.full(2 * n, size))
        assert abs(noise) < 4 / np.sqrt(n)
        assert shape == pytest.approx(np.sqrt(1 / 3), abs=0.05)
        assert shape > PARAMETERS.most_alike


@pytest.mark.parametrize("size", [60, 90])
def test_creases_across_the_mesh_are_not_removed(size):
    """A folded sheet, whose triangles make teeth of its creases, with less noise than teeth."""
    points, faces = meshes.flat_grid(size, size)
    points[:, 2] = np.abs(points[:, 0] % 10 - 5)
    surface = TriangleSurface(TriangleTopology(faces, len(points)), points)
    numbers = np.random.default_rng(0).normal(size=len(points))
    noisy_points = points + 0.1 * numbers[:, None] * surface.normals
    found = denoise(noisy_points, faces)
    before, after = (np.linalg.norm(each - points) for each in (noisy_points, found.positions))
    assert after <= before


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noise_that_is_stronger_on_a_third_of_a_ball_is_removed(seed):
    """It comes in one cluster, but then it is white around every vertex."""
    ball, faces = meshes.icosphere(4)
    strength = np.where(ball[:, 2:] > 0.3, 2.5, 1)
    numbers = np.random.default_rng(seed).normal(size=(len(ball), 1))
    points = ball * (1 + 0.0084 * strength * numbers)
    before, after = (
        np.std(np.linalg.norm(each, axis=1)) for each in (points, denoise(points, faces).positions)
    )
    assert after < 0.4 * before


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_comes_in_clusters_is_not_removed(seed):
    """Roughness much stronger in stripes of a few edges; noise is as strong between them."""
    ball, faces = meshes.icosphere(4)
    strength = np.where(np.sin(5 * np.pi * ball[:, 2:]) > 0.3, 3, 1)
    numbers = np.random.default_rng(seed).normal(size=(len(ball), 1))
    points = ball * (1 + 0.0084 * strength * numbers)
    found = denoise(points, faces)
    assert np.array_equal(found.positions, points)
    assert UNLIKE_NOISE in found.notes
    assert found.other_readings == ("denoise",)
    with using(replace(PARAMETERS, most_clustered=2.0)):
        assert not np.array_equal(denoise(points, faces).positions, points)


def test_a_note_tells_that_what_was_removed_may_be_detail():
    """Roughness twice as strong in stripes of a few edges; the other reading keeps it."""
    ball, faces = meshes.icosphere(4)
    strength = np.where(np.sin(5 * np.pi * ball[:, 2:]) > 0.3, 2.2, 1)
    numbers = np.random.default_rng(1).normal(size=(len(ball), 1))
    points = ball * (1 + 0.0084 * strength * numbers)
    found = denoise(points, faces)
    assert LIKE_DETAIL in found.notes
    assert found.other_readings == ("detail",)
    kept = denoise(points, faces, DenoiseSettings(clean="detail"))
    assert np.array_equal(kept.positions, points)
    assert kept.other_readings == ("denoise",)
    even = ball * (1 + 0.0084 * numbers)
    assert not denoise(even, faces).notes


@pytest.mark.parametrize(("signs", "part"), [(0.6, 1), (0.8, 0.6), (0.99, 0.03), (1, 0)])
def test_less_is_removed_the_more_signs_of_shape_there_are(signs, part, monkeypatch):
    """Nothing leaps where they reach their limit."""
    points = noisy(BALL, FACES, 0.1)
    whole = denoise(points, FACES)
    monkeypatch.setattr(CleanDetail, "shape", lambda *_: (signs, "it has edges"))
    found = denoise(points, FACES)
    moved, most = (np.linalg.norm(each.positions - points) for each in (found, whole))
    # Along the surface vertices go as far as triangles let them.
    assert moved == pytest.approx(part * most, rel=0.1)
    in_doubt = 0 < part < 1
    assert (IN_DOUBT in found.notes) == in_doubt
    if in_doubt:
        assert found.other_readings == ("detail", "denoise")
        kept, removed = (
            denoise(points, FACES, DenoiseSettings(clean=each)) for each in found.other_readings
        )
        assert np.array_equal(kept.positions, points)
        assert np.linalg.norm(removed.positions - points) > 0.9 * most


@pytest.mark.parametrize("part", [0.05, 0.1, 0.15, 0.2, 0.25])
def test_a_smooth_patch_does_not_turn_the_rest_into_shape(part):
    """A hole that was filled, or what was denoised before, has no noise."""
    ball, faces = meshes.icosphere(4)
    # Uneven, so that no triangle is a copy of another, as in a model.
    ball = ball + np.random.default_rng(6).uniform(-0.01, 0.01, ball.shape)
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    rough = ball[:, 2:] < 1 - 2 * part
    points = np.where(rough, noisy(ball, faces, 0.2), ball)
    found = denoise(points, faces)
    assert UNLIKE_NOISE not in found.notes
    before, after = (np.linalg.norm(each - ball) for each in (points, found.positions))
    assert after < 0.9 * before


def test_where_the_hinges_decide_roughness_that_fades_is_no_detail(monkeypatch):
    """Creases in every row: they make the roughness, and it may fade as it likes."""
    vertices, faces = meshes.flat_grid(48, 48)
    row = np.rint(vertices[:, 1] / np.sqrt(0.75)).astype(int)
    random = np.random.default_rng(0)
    vertices = vertices + 0.15 * random.normal(size=vertices.shape) * [1, 0, 0]
    vertices[:, 2] = 0.5 * random.normal(size=49)[row] + 0.08 * random.normal(size=len(vertices))
    frame = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    parts = MeshParts(frame, np.zeros(len(vertices), dtype=bool))
    surface = NoisySurface(vertices, frame)
    level = parts.noise(surface).level[parts.is_counted]
    assert np.median(level) == pytest.approx(0.08, rel=0.3)
    assert np.median(level) < 0.7 * np.median(surface.roughness.value[parts.is_counted]) / 0.6745
    monkeypatch.setattr(CleanDetail, "fades", lambda self, is_counted: True)
    assert np.array_equal(parts.noise(surface).level[parts.is_counted], level)
