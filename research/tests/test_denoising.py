"""The benchmark of denoising: its noise has the strength it says, its measures and verdict hold.

The peers and shapes that need the extra "research" are not run here.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.special import erf
from support.meshes import flat_grid, graded_sphere, icosphere

from research.denoising import blender_modifiers, contest, noise, pairs, scans, verdict
from research.denoising.measures import N_CLASSES, Reference
from research.denoising.peers import Peer
from tools.geometry.ply import write_ply
from tools.geometry.triangles import (
    edges_of,
    local_edge_lengths,
    normals,
    scaled_normals,
    vertex_normals,
)

AMPLITUDE = 0.1


@pytest.fixture(scope="module")
def ball() -> tuple[np.ndarray, np.ndarray]:
    """Make a sphere of uneven density."""
    return graded_sphere(4)


def heights(ball, kind: str, amplitude: float = AMPLITUDE) -> np.ndarray:
    """Return the noise along the normals, over the local edge length."""
    vertices, faces = ball
    moves = noise.add_noise(vertices, faces, kind, amplitude, seed=3) - vertices
    normal = vertex_normals(vertices, faces)
    return np.einsum("nd,nd->n", moves, normal) / local_edge_lengths(vertices, faces)


@pytest.mark.parametrize(
    ("kind", "tolerance"),  # about three standard deviations: outliers and correlation widen them
    [("normal", 0.08), ("isotropic", 0.08), ("heavy-tailed", 0.16), ("correlated-2", 0.16)],
)
def test_noise_is_as_strong_as_it_says_everywhere(ball, kind, tolerance):
    vertices, faces = ball
    found = heights(ball, kind)
    edges = local_edge_lengths(vertices, faces)
    for part in (edges < np.median(edges), edges >= np.median(edges)):
        assert np.sqrt(np.mean(np.square(found[part]))) == pytest.approx(AMPLITUDE, rel=tolerance)


def test_uniform_noise_is_as_strong_in_lengths_everywhere(ball):
    edges = local_edge_lengths(*ball)
    lengths = heights(ball, "uniform") * edges
    for part in (edges < np.median(edges), edges >= np.median(edges)):
        expected = AMPLITUDE * edges.mean()
        assert np.sqrt(np.mean(np.square(lengths[part]))) == pytest.approx(expected, rel=0.08)


def test_only_isotropic_noise_moves_sideways(ball):
    vertices, faces = ball
    edges = local_edge_lengths(vertices, faces)
    for kind in noise.KINDS:
        moves = noise.add_noise(vertices, faces, kind, AMPLITUDE, seed=3) - vertices
        normal = vertex_normals(vertices, faces)
        sideways = np.linalg.norm(np.cross(moves, normal), axis=1) / edges
        expected = AMPLITUDE * 2**0.5 if kind == "isotropic" else 0.0
        assert np.sqrt(np.mean(np.square(sideways))) == pytest.approx(expected, rel=0.08, abs=1e-12)


def test_correlated_noise_is_shared_over_the_length_it_says(ball):
    """The correlation at distance r is exp(-(r / length)²), r in edges."""
    vertices, faces = icosphere(5)
    points, edge = vertices[::7], local_edge_lengths(vertices, faces).mean()
    first, second = np.triu_indices(len(points), 1)
    distance = np.linalg.norm(points[first] - points[second], axis=1) / edge
    for length in noise.CORRELATION_LENGTHS:
        found = heights((vertices, faces), f"correlated-{length}")[::7]
        shell = np.abs(distance / length - 1) < 0.2
        expected = np.mean(np.exp(-np.square(distance[shell] / length)))
        # There are about n / length² independent places. Two passes are not quite a Gaussian yet.
        error = 3 * length / len(vertices) ** 0.5 + 0.2 / length**2
        products = found[first[shell]] * found[second[shell]] / AMPLITUDE**2
        assert np.mean(products) == pytest.approx(expected, abs=error)


def test_other_noise_is_not_shared_by_neighbours(ball):
    first, second = edges_of(ball[1]).T
    for kind in noise.KINDS:
        if not kind.startswith("correlated"):
            found = heights(ball, kind)
            assert abs(np.corrcoef(found[first], found[second])[0, 1]) < 0.05


def test_impulsive_noise_leaves_most_vertices_where_they_are(ball):
    found = heights(ball, "impulsive")
    hit = np.abs(found) > 1e-12
    assert hit.mean() == pytest.approx(noise.SPIKES, abs=0.03)
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(AMPLITUDE, rel=0.1)


def test_heavy_tailed_noise_has_the_quantiles_of_the_contaminated_normal(ball):
    found = np.abs(heights(ball, "heavy-tailed")) / AMPLITUDE
    scale = (1 + noise.OUTLIERS * (noise.OUTLIER_SCALE**2 - 1)) ** -0.5
    for share in (0.5, 0.9, 0.98):
        level = np.quantile(found, share) / scale
        below = (1 - noise.OUTLIERS) * erf(level / 2**0.5)
        below += noise.OUTLIERS * erf(level / noise.OUTLIER_SCALE / 2**0.5)
        spread = (share * (1 - share) / len(found)) ** 0.5
        assert below == pytest.approx(share, abs=4 * spread)


@pytest.fixture(scope="module")
def scanned() -> tuple[np.ndarray, np.ndarray]:
    """Make a fine sphere of radius 1, for scanners to look at."""
    return icosphere(5)


@pytest.mark.parametrize("scan", [scans.depth_camera, scans.range_scanner])
def test_a_scan_shows_the_surface_and_errs_along_the_line_of_sight(scanned, scan):
    clean, noisy, faces = scan(*scanned, 0.5, np.random.default_rng(1))
    pixel = scans.PIXEL * local_edge_lengths(*scanned).mean()
    sagitta = np.square(1.1 * local_edge_lengths(*scanned).max()) / 2
    radius = np.linalg.norm(clean, axis=1)
    assert 1 - sagitta < radius.min() and radius.max() < 1 + 1e-6
    toward = scans.VIEW / np.linalg.norm(scans.VIEW)
    assert (scaled_normals(clean, faces) @ toward).min() > 0  # all are seen from the front
    moved = noisy - clean
    np.testing.assert_allclose(np.cross(moved, toward), 0, atol=1e-12)
    if scan is scans.range_scanner:
        facing = clean @ toward > 0.9
        error = np.sqrt(np.mean(np.square(moved[facing] @ toward * (clean[facing] @ toward))))
        assert error == pytest.approx(0.5 * pixel, rel=0.1)


def test_errors_of_a_depth_camera_are_as_alike_as_measured(scanned):
    clean, noisy, _ = scans.depth_camera(*scanned, 0.3, np.random.default_rng(1))
    toward = scans.VIEW / np.linalg.norm(scans.VIEW)
    error = (noisy - clean) @ toward
    pixel = scans.PIXEL * local_edge_lengths(*scanned).mean()
    flat = clean - np.outer(clean @ toward, toward)
    tree = cKDTree(flat)
    for rings, expected in ((1, 0.84), (2, 0.5), (3, 0.21)):  # exp(-rings² / (4 FILTER²))
        pairs_of_pixels = tree.query_pairs(pixel * (rings + 0.1), output_type="ndarray")
        gaps = np.linalg.norm(flat[pairs_of_pixels[:, 0]] - flat[pairs_of_pixels[:, 1]], axis=1)
        first, second = pairs_of_pixels[gaps > pixel * (rings - 0.1)].T
        found = np.corrcoef(error[first], error[second])[0, 1]
        assert found == pytest.approx(expected, abs=0.06)


def test_noise_is_the_same_on_every_run(ball):
    once, again = (noise.add_noise(*ball, "normal", AMPLITUDE, seed=5) for _ in range(2))
    np.testing.assert_array_equal(once, again)
    other = noise.add_noise(*ball, "normal", AMPLITUDE, seed=6)
    assert np.abs(other - once).max() > 0


def test_a_clean_result_has_no_errors(ball):
    vertices, faces = ball
    found = Reference(vertices, faces).score(vertices)
    assert found["volume"] is not None
    assert (found.pop("boundary"), found.pop("area")) == (None, None)  # it is closed
    assert found.pop("classes") == pytest.approx([0.0] * N_CLASSES, abs=1e-12)
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-5)  # arccos near 1 is coarse


def test_a_swollen_sphere_is_measured_exactly():
    vertices, faces = icosphere(3)
    reference = Reference(vertices, faces)
    found = reference.score(1.01 * vertices)
    # Nearest to a point straight above a corner of a convex body is the corner.
    outwards = 0.01 / reference.local_edges
    # Nearest to that corner, on the swollen body, is a triangle around it: the planes are parallel.
    heights = np.einsum("fd,fd->f", vertices[faces[:, 0]], normals(vertices, faces))
    beside = np.full(len(vertices), np.inf)
    np.minimum.at(beside, faces, heights[:, None])
    expected = [outwards, beside * outwards]
    np.testing.assert_allclose(reference.distances(1.01 * vertices), expected, rtol=1e-9)
    assert found["mean"] == pytest.approx(np.sqrt(np.mean(np.square(expected))), rel=1e-9)
    assert found["moved"] == pytest.approx(np.sqrt(np.mean(outwards**2)), rel=1e-9)
    assert found["volume"] == pytest.approx(1.01**3 - 1, rel=1e-9)
    assert found["angle"] == pytest.approx(0, abs=1e-5)
    assert found["flips"] == 0


def test_sliding_within_the_surface_is_no_error_but_a_move():
    vertices, faces = flat_grid(12, 12)
    inside = np.ones(len(vertices), dtype=bool)
    inside[np.unique(edges_of(faces)[_boundary(faces)])] = False
    slid = vertices.copy()
    slid[inside, 0] += 0.2 * local_edge_lengths(vertices, faces)[inside]
    found = Reference(vertices, faces).score(slid)
    assert found["mean"] == pytest.approx(0, abs=1e-12)
    assert found["volume"] is None  # it is open
    assert found["moved"] == pytest.approx(0.2 * np.sqrt(inside.mean()), rel=1e-9)
    assert found["flips"] == 0


def test_a_rim_drawn_inwards_is_an_error_of_what_is_missing():
    n = 24
    turn = 2 * np.pi * np.arange(n) / n
    boundary = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    vertices = np.concatenate([np.zeros((1, 3)), boundary])
    faces = np.stack([0 * turn, 1 + np.arange(n), 1 + np.roll(np.arange(n), -1)], axis=1)
    reference = Reference(vertices, faces.astype(np.int32))
    found = reference.score(0.9 * vertices)
    # Nearest to a corner of the small polygon is a side of the large one; the other way a corner.
    square = np.mean(np.square([0.1 * np.cos(np.pi / n), 0.1]))
    assert found["boundary"] == pytest.approx(np.sqrt(square) / reference.local_edges[1], rel=1e-9)
    assert found["area"] == pytest.approx(0.81 - 1, rel=1e-9)
    # All vertices of the small disc lie on the large one, but the corners of that stick out of it.
    missing = 0.1 / reference.local_edges[1:]
    expected = np.concatenate([np.zeros(n + 2), missing])
    assert found["mean"] == pytest.approx(np.sqrt(np.mean(np.square(expected))), rel=1e-9)
    np.testing.assert_allclose(
        np.sort(reference.distances(0.9 * vertices).ravel()), expected, atol=1e-12
    )


def test_a_rim_pushed_outwards_is_as_large_an_error():
    vertices, faces = flat_grid(12, 12)
    small, large = Reference(vertices, faces), Reference(1.1 * vertices, faces)
    outwards, inwards = small.distances(1.1 * vertices), large.distances(vertices)
    np.testing.assert_allclose(1.1 * inwards[::-1], outwards, atol=1e-12)


def _boundary(faces: np.ndarray) -> np.ndarray:
    pairs_of_ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    counts = np.unique(pairs_of_ends, axis=0, return_counts=True)[1]
    return counts == 1


def test_noise_along_the_normals_is_the_distance_measured(ball):
    vertices, faces = ball
    noisy = noise.add_noise(vertices, faces, "normal", AMPLITUDE, seed=3)
    found = Reference(vertices, faces).score(noisy)
    assert found["mean"] == pytest.approx(AMPLITUDE, rel=0.05)
    assert found["classes"] == pytest.approx([AMPLITUDE] * N_CLASSES, rel=0.1)
    assert found["worst"] == max(found["classes"])


def test_turned_faces_are_counted():
    vertices, faces = flat_grid(6, 6)
    found = Reference(vertices, faces).score(vertices * [-1, 1, 1])
    assert found["flips"] == len(faces)
    assert found["angle"] == pytest.approx(180)


def test_density_classes_are_equal_shares_from_dense_to_coarse(ball):
    reference = Reference(*ball)
    counts = np.bincount(reference.density_class)
    assert len(counts) == N_CLASSES
    assert np.ptp(counts) <= 0.01 * len(ball[0])
    for k in range(N_CLASSES - 1):
        longest = reference.local_edges[reference.density_class == k].max()
        assert longest <= reference.local_edges[reference.density_class == k + 1].min()


def test_pairs_of_a_folder_are_read_with_their_faces(ball, tmp_path):
    vertices, faces = ball
    noisy = noise.add_noise(vertices, faces, "normal", AMPLITUDE, seed=3)
    write_ply(tmp_path / "some.ball.clean.ply", vertices, faces, "test")
    write_ply(tmp_path / "some.ball.noisy.ply", noisy, faces, "test")
    write_ply(tmp_path / "alone.ply", vertices, faces, "test")
    found, without_noise = pairs.in_folder(tmp_path)
    assert (found.name, found.label) == ("some.ball", "some.ball")
    assert (without_noise.label, without_noise.noise) == ("some.ball_none", pairs.CLEAN)
    np.testing.assert_array_equal(without_noise.noisy, found.clean)
    np.testing.assert_array_equal(found.faces, faces)
    np.testing.assert_allclose(found.clean, vertices, atol=1e-6)
    np.testing.assert_allclose(found.noisy, noisy, atol=1e-6)


def test_a_pair_with_other_faces_is_refused(ball, tmp_path):
    vertices, faces = ball
    write_ply(tmp_path / "a.clean.ply", vertices, faces, "test")
    write_ply(tmp_path / "a.noisy.ply", vertices, faces[:, [1, 2, 0]], "test")
    with pytest.raises(ValueError, match="other faces"):
        list(pairs.in_folder(tmp_path))


@pytest.mark.parametrize("text", ["normal", "normal:0", "normal:-1", "nothing:0.1", "none:0.1"])
def test_a_noise_that_is_none_is_refused(text):
    with pytest.raises(ValueError):
        pairs.noise_name(text)


def test_every_kind_of_noise_has_a_name_that_is_understood():
    assert [pairs.noise_name(text) for text in pairs.ALL_NOISE] == list(pairs.ALL_NOISE)


class Shrinking:
    """A peer's run that counts how often it is called: towards the sphere, then far past it."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, vertices, faces, sweep) -> Iterator[np.ndarray]:
        radius = np.linalg.norm(vertices, axis=1, keepdims=True)
        for value in sweep:
            self.calls += 1
            yield vertices * (1 + value * (1 / radius - 1))


@pytest.fixture
def pair(ball) -> pairs.Pair:
    vertices, faces = ball
    noisy = noise.add_noise(vertices, faces, "normal", AMPLITUDE, seed=3)
    return pairs.Pair("ball", "test", "test", "normal:0.1", vertices, noisy, faces)


def test_scores_of_a_peer_are_kept_until_its_grid_changes(pair, tmp_path):
    run = Shrinking()
    peer = Peer("shrinking", (), "share", (0.5, 1.0), run)
    once = contest.peer_scores(pair, peer, tmp_path)
    assert run.calls == 2
    assert contest.peer_scores(pair, peer, tmp_path) == once
    assert run.calls == 2
    wider = Peer("shrinking", (), "share", (0.5, 1.0, 1.5), run)
    assert len(contest.peer_scores(pair, wider, tmp_path)) == 3
    assert once["share 1"]["mean"] < 0.02 < once["share 0.5"]["mean"]


def test_the_result_at_a_point_of_the_grid_is_the_one_that_was_scored(pair):
    peer = Peer("shrinking", (), "share", (0.5, 1.0, 1.2), Shrinking(), {"a": {}, "b": {}})
    positions = peer.result(pair.noisy, pair.faces, "share 1, b")
    expected = contest.peer_scores(pair, peer)["share 1, b"]
    assert Reference(pair.clean, pair.faces).score(positions).items() <= expected.items()
    with pytest.raises(KeyError, match="no share 2"):
        peer.result(pair.noisy, pair.faces, "share 2")


def test_a_sweep_ends_where_it_is_hopeless(pair):
    run = Shrinking()
    peer = Peer("shrinking", (), "share", (0.5, 0.9, 3.0, 5.0, 7.0), run)
    assert list(contest.peer_scores(pair, peer)) == ["share 0.5", "share 0.9", "share 3"]


def test_the_ends_of_a_grid_are_known():
    counted = Peer("counted", (), "iterations", (1, 2, 4), Shrinking(), {"a": {}, "b": {}})
    names = [counted.parameter(variant, value) for variant in "ab" for value in (1, 2, 4)]
    assert [counted.at_edge(name) for name in names] == [False, False, True] * 2
    timed = Peer("timed", (), "time", (1, 2, 4), Shrinking(), starts_at_least=False)
    assert [timed.at_edge(timed.parameter("", value)) for value in (1, 2, 4)] == [True, False, True]


def made_up(mean: float, **others) -> dict:
    return {
        "mean": mean,
        "worst": mean,
        "angle": mean,
        "flips": 0,
        "moved": 0.0,
        "seconds": 1.0,
    } | others


def peer(name: str, published: str | None = None) -> Peer:
    return Peer(name, (), "", (0, 1), Shrinking(), published=published)


FIRST, SECOND = peer("first"), peer("second")


def entry(own: float, first: list[float], second: list[float], **others) -> contest.Entry:
    """Make an entry with scores of two peers, at parameters called 0, 1 ..."""
    scores = {
        name: {str(k): made_up(mean) for k, mean in enumerate(means)}
        for name, means in (("first", first), ("second", second))
    }
    nothing = np.empty((0, 3))
    mesh = pairs.Pair("mesh", "test", "test", "normal:0.1", nothing, nothing, nothing)
    return contest.Entry(mesh, made_up(0.2), made_up(own, **others), scores)


def test_the_verdict_takes_the_best_parameter_per_mesh_and_one_for_all():
    entries = [entry(0.09, [0.1, 0.2], [0.4, 0.4]), entry(0.08, [0.5, 0.12], [0.1, 0.3])]
    assert verdict.best_peer(entries[0], [FIRST, SECOND])[:2] == ("first", "0")
    assert verdict.best_peer(entries[1], [FIRST, SECOND])[:2] == ("second", "0")
    single = verdict.one_parameter(entries, FIRST)
    assert single.parameter == "1"  # 0.2 · 0.12 is less than 0.1 · 0.5
    assert [each["mean"] for each in single.scores] == [0.2, 0.12]
    found = verdict.standing(entries, [FIRST, SECOND])
    assert found.best == pytest.approx([(0.9 * 0.8) ** 0.5] * 2)
    assert found.largest == pytest.approx(0.9)
    assert found.worst == pytest.approx(found.best[0])
    assert found.fixed == pytest.approx([(0.09 / 0.2 * 0.08 / 0.1) ** 0.5] * 2)
    assert (found.flips, found.seconds) == (1.0, 1.0)


def test_what_the_authors_publish_is_the_one_parameter():
    entries = [entry(0.09, [0.1, 0.2], [0.4, 0.4]), entry(0.08, [0.5, 0.12], [0.1, 0.3])]
    single = verdict.one_parameter(entries, peer("first", published="0"))
    assert [each["mean"] for each in single.scores] == [0.1, 0.5]


def test_a_parameter_that_failed_on_one_mesh_is_not_the_one_for_all():
    entries = [entry(0.1, [0.1, 0.2], [0.1]), entry(0.1, [0.1, 0.2], [0.1])]
    del entries[1].peers["first"]["0"]
    assert verdict.one_parameter(entries, FIRST).parameter == "1"


@pytest.mark.parametrize(
    ("run", "options"),
    [
        (blender_modifiers.smooth, {}),
        (blender_modifiers.corrective_smooth, {"weights": "LENGTH_WEIGHTED"}),
    ],
)
def test_going_on_from_the_last_result_is_what_more_iterations_do(ball, run, options):
    *_, piecewise = run(*ball, (1, 2, 5), **options)
    (at_once,) = run(*ball, (5,), **options)
    np.testing.assert_allclose(piecewise, at_once, atol=2e-6)
    assert np.abs(at_once - ball[0]).max() > 1e-3
