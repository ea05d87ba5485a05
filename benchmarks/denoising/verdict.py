"""From scores to a verdict: best parameters, one parameter for all meshes, what must be shown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .contest import Entry
from .measures import Score
from .peers import Peer

MEAN_GOAL, MEAN_LIMIT, WORST_GOAL, CLEAN_GOAL = 0.90, 1.05, 0.95, 0.01

PUBLISHED_GOALS, BEST_GOALS, KIND_LIMITS, MESH_LIMIT = (0.80, 0.85), (0.95, 1.0), (1.0, 1.1), 1.2
"""Error and angle over the research peers', see `Standing`."""


class Point(NamedTuple):
    """A peer at one parameter, on one mesh."""

    peer: str
    parameter: str
    score: Score


@dataclass(frozen=True)
class OneParameter:
    """A peer at the one parameter that is best for all meshes together.

    Attributes
    ----------
    peer, parameter
        Names.
    scores
        On every mesh, in their order.
    """

    peer: str
    parameter: str
    scores: tuple[Score, ...]


@dataclass(frozen=True)
class Criterion:
    """One thing that must be shown, and whether it was."""

    text: str
    found: str
    passed: bool


def geometric_mean(values: Sequence[float]) -> float:
    """Return exp of the mean logarithm."""
    return float(np.exp(np.mean(np.log(values))))


def best_of(entry: Entry, peer: str, measure: str = "mean") -> Point:
    """Return a peer at the parameter that makes a measure least on this mesh."""
    scores = entry.peers[peer]
    parameter = min(scores, key=lambda name: scores[name][measure])
    return Point(peer, parameter, scores[parameter])


def best_peer(entry: Entry, names: Sequence[str], measure: str = "mean") -> Point:
    """Return the best of the peers at the best of its parameters."""
    points = [best_of(entry, name, measure) for name in names if entry.peers[name]]
    return min(points, key=lambda point: point.score[measure])


def one_parameter(entries: Sequence[Entry], peer: str) -> OneParameter:
    """Return a peer at the parameter with the least geometric mean of its mean errors.

    Only parameters with a score on every mesh count: where one has none, the peer failed with it or
    was far past its best.
    """
    grids = [entry.peers[peer] for entry in entries]
    common = [name for name in grids[0] if all(name in grid for grid in grids)]
    if not common:
        raise ValueError(f"{peer} has no parameter that works on every mesh")
    errors = {name: geometric_mean([grid[name]["mean"] for grid in grids]) for name in common}
    best = min(errors, key=errors.__getitem__)
    return OneParameter(peer, best, tuple(grid[best] for grid in grids))


def criteria(entries: Sequence[Entry], names: Sequence[str]) -> list[Criterion]:
    """Judge auto on noisy meshes against the peers of these names."""
    best = [best_peer(entry, names).score for entry in entries]
    worst = [best_peer(entry, names, "worst").score for entry in entries]
    ours = [entry.auto for entry in entries]

    def ratios(measure: str, others: Sequence[Score]) -> list[float]:
        return [own[measure] / other[measure] for own, other in zip(ours, others, strict=True)]

    mean, low = ratios("mean", best), ratios("worst", worst)
    singles = [one_parameter(entries, name) for name in names]
    below = sum(
        all(own["mean"] < single.scores[k]["mean"] for single in singles)
        for k, own in enumerate(ours)
    )
    flips = sum(own["flips"] <= other["flips"] for own, other in zip(ours, best, strict=True))
    n = len(entries)

    def at_most(text: str, value: float, goal: float) -> Criterion:
        return Criterion(f"{text} ≤ {goal:.2f}", f"{value:.3f}", value <= goal)

    def all_of(text: str, count: int) -> Criterion:
        return Criterion(text, f"{count} of {n} meshes", count == n)

    return [
        at_most(
            "mean error over the best peer's at its best parameter, geometric mean",
            geometric_mean(mean),
            MEAN_GOAL,
        ),
        at_most("the same, largest of all meshes", max(mean), MEAN_LIMIT),
        all_of("mean error below every peer's at one parameter", below),
        at_most(
            "worst class over the best peer's at its best parameter, geometric mean",
            geometric_mean(low),
            WORST_GOAL,
        ),
        at_most("the same, largest of all meshes", max(low), MEAN_LIMIT),
        all_of("flipped faces no more than the best peer's", flips),
    ]


@dataclass(frozen=True)
class Standing:
    """Auto over the best of the research peers, on meshes with one kind of noise.

    Attributes
    ----------
    published, best
        Geometric means of error and angle over the least of any peer: at its published parameters,
        and at the best of its grid on every mesh.
    largest
        Of the errors over the best, on one mesh.
    flips
        Share of the meshes without more flipped faces than the peer with the least error at its
        published parameters.
    seconds
        Processor time over that peer's, geometric mean.
    """

    published: tuple[float, float]
    best: tuple[float, float]
    largest: float
    flips: float
    seconds: float


def standing(entries: Sequence[Entry], peers: Sequence[Peer]) -> Standing:
    """Compare auto with research peers."""
    ours = [entry.auto for entry in entries]
    at_published = [[entry.peers[peer.name][peer.published] for peer in peers] for entry in entries]
    on_grid = [
        [score for peer in peers for score in entry.peers[peer.name].values()] for entry in entries
    ]

    def ratios(scores: list[list[Score]], measure: str) -> list[float]:
        least = [min(score[measure] for score in some) for some in scores]
        return [own[measure] / other for own, other in zip(ours, least, strict=True)]

    def means(scores: list[list[Score]]) -> tuple[float, float]:
        return geometric_mean(ratios(scores, "mean")), geometric_mean(ratios(scores, "angle"))

    rivals = [min(some, key=lambda score: score["mean"]) for some in at_published]
    both = list(zip(ours, rivals, strict=True))
    return Standing(
        means(at_published),
        means(on_grid),
        max(ratios(on_grid, "mean")),
        float(np.mean([own["flips"] <= rival["flips"] for own, rival in both])),
        geometric_mean([own["seconds"] / rival["seconds"] for own, rival in both]),
    )


def research_criteria(kinds: Sequence[Standing], overall: Standing) -> list[Criterion]:
    """Judge auto against research peers: kind by kind, and on all meshes together."""

    def at_most(text: str, found: Sequence[float], goals: Sequence[float]) -> Criterion:
        return Criterion(
            f"{text} ≤ {_slashed(goals)}",
            _slashed(found),
            all(value <= goal for value, goal in zip(found, goals, strict=True)),
        )

    def worst(which: str) -> list[float]:
        return [max(values) for values in zip(*(getattr(kind, which) for kind in kinds))]  # noqa: B905

    return [
        at_most("published parameters, worst kind of noise", worst("published"), PUBLISHED_GOALS),
        at_most("best parameter per mesh, all", overall.best, BEST_GOALS),
        at_most("best parameter per mesh, worst kind of noise", worst("best"), KIND_LIMITS),
        at_most("best parameter, error on the worst mesh", [overall.largest], [MESH_LIMIT]),
        Criterion(
            "no more flipped faces, on nine meshes of ten",
            f"{overall.flips:.0%}",
            overall.flips >= 0.9,
        ),
    ]


def _slashed(values: Sequence[float]) -> str:
    return " / ".join(f"{value:.2f}" for value in values)


def clean_criterion(entries: Sequence[Entry]) -> Criterion:
    """Judge auto on clean meshes: they must come back as they were."""
    moved = max(entry.auto["moved"] for entry in entries)
    return Criterion(
        f"clean meshes moved by less than {CLEAN_GOAL:g} edges, largest of {len(entries)} meshes",
        f"{moved:.4f}",
        moved < CLEAN_GOAL,
    )


def grouped(entries: Sequence[Entry], key: Callable[[Entry], str]) -> dict[str, list[Entry]]:
    """Return entries by a key, in the order in which the keys appear."""
    groups: dict[str, list[Entry]] = {}
    for entry in entries:
        groups.setdefault(key(entry), []).append(entry)
    return groups
