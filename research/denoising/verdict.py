"""From scores to a verdict: best parameters, and one parameter for all meshes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .contest import Entry
from .measures import Score
from .peers import Peer


class Point(NamedTuple):
    """A peer at one parameter, on one mesh."""

    peer: str
    parameter: str
    score: Score


class OneParameter(NamedTuple):
    """A peer at one parameter for all meshes, and its scores on every mesh, in their order."""

    peer: str
    parameter: str
    scores: tuple[Score, ...]


@dataclass(frozen=True)
class Standing:
    """Auto over the best of some peers.

    Attributes
    ----------
    fixed, best
        Geometric means of error and angle over the least of any peer: each at its one parameter,
        see `one_parameter`, and each at the best of its grid on every mesh.
    worst
        The same of the error in the worst density class, over the best of the grids.
    largest
        Of the errors over the best, on one mesh.
    flips
        Fraction of the meshes without more flipped faces than the peer with the least error at its
        one parameter.
    seconds
        Processor time over that peer's, geometric mean.
    """

    fixed: tuple[float, float]
    best: tuple[float, float]
    worst: float
    largest: float
    flips: float
    seconds: float


def geometric_mean(values: Sequence[float]) -> float:
    """Return exp of the mean logarithm."""
    return float(np.exp(np.mean(np.log(values))))


def best_of(entry: Entry, peer: str, measure: str = "mean") -> Point:
    """Return a peer at the parameter that makes a measure least on this mesh."""
    scores = entry.peers[peer]
    parameter = min(scores, key=lambda name: scores[name][measure])
    return Point(peer, parameter, scores[parameter])


def best_peer(entry: Entry, peers: Sequence[Peer], measure: str = "mean") -> Point:
    """Return the best of the peers at the best of its parameters."""
    points = [best_of(entry, peer.name, measure) for peer in peers if entry.peers[peer.name]]
    return min(points, key=lambda point: point.score[measure])


def one_parameter(entries: Sequence[Entry], peer: Peer) -> OneParameter:
    """Return a peer at the parameter of its authors, or else at the best one for all meshes.

    That is the one with the least geometric mean of the errors. Only parameters with a score on
    every mesh count: where one has none, the peer failed with it or was far past its best.
    """
    grids = [entry.peers[peer.name] for entry in entries]
    common = [name for name in grids[0] if all(name in grid for grid in grids)]
    if not common:
        raise ValueError(f"{peer.name} has no parameter that works on every mesh")
    errors = {name: geometric_mean([grid[name]["mean"] for grid in grids]) for name in common}
    best = peer.published or min(errors, key=errors.__getitem__)
    return OneParameter(peer.name, best, tuple(grid[best] for grid in grids))


def standing(entries: Sequence[Entry], peers: Sequence[Peer]) -> Standing:
    """Compare Denoise with peers."""
    ours = [entry.ours for entry in entries]
    fixed = list(zip(*(one_parameter(entries, peer).scores for peer in peers), strict=True))
    grids = [
        [score for peer in peers for score in entry.peers[peer.name].values()] for entry in entries
    ]

    def ratios(scores: Sequence[Sequence[Score]], measure: str) -> list[float]:
        least = [min(score[measure] for score in some) for some in scores]
        return [own[measure] / other for own, other in zip(ours, least, strict=True)]

    def means(scores: Sequence[Sequence[Score]]) -> tuple[float, float]:
        return geometric_mean(ratios(scores, "mean")), geometric_mean(ratios(scores, "angle"))

    rivals = [min(some, key=lambda score: score["mean"]) for some in fixed]
    both = list(zip(ours, rivals, strict=True))
    return Standing(
        means(fixed),
        means(grids),
        geometric_mean(ratios(grids, "worst")),
        max(ratios(grids, "mean")),
        float(np.mean([own["flips"] <= rival["flips"] for own, rival in both])),
        geometric_mean([own["seconds"] / rival["seconds"] for own, rival in both]),
    )


def slashed(values: Sequence[float]) -> str:
    """Show numbers with slashes between them."""
    return " / ".join(f"{value:.2f}" for value in values)


def grouped(entries: Sequence[Entry], key: Callable[[Entry], str]) -> dict[str, list[Entry]]:
    """Return entries by a key, in the order in which the keys appear."""
    groups: dict[str, list[Entry]] = {}
    for entry in entries:
        groups.setdefault(key(entry), []).append(entry)
    return groups
