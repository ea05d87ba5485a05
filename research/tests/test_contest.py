"""Contest and verdict of the benchmark of denoising: pairs, sweeps over grids, best parameters.

The peers and shapes that need the extra "research" are not run here.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from research.denoising import blender_modifiers, contest, noise, pairs, verdict
from research.denoising.measures import Reference
from research.denoising.peers import Peer
from tools.geometry.ply import write_ply


def test_pairs_of_a_folder_are_read_with_their_faces(ball, tmp_path):
    vertices, faces = ball
    noisy = noise.add_noise(vertices, faces, "normal", 0.1, seed=3)
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
    noisy = noise.add_noise(vertices, faces, "normal", 0.1, seed=3)
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
