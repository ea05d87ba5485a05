"""Tables in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.measuring import table

from .contest import Entry
from .measures import Score
from .peers import Peer
from .verdict import Standing, best_of, best_peer, geometric_mean, one_parameter, slashed

Rows = list[list[str]]


def in_short(entries: Sequence[Entry], peers: Sequence[Peer]) -> str:
    """Means over all meshes: error and time geometric, the angle arithmetic.

    Peers are at their published parameter; those that have none, at the best for each mesh.
    """
    seconds = [entry.ours["seconds"] for entry in entries]
    rows = [_means("noisy", "", [entry.noisy for entry in entries], seconds)]
    for peer in peers:
        if peer.published is None:
            how, found = "best for each mesh", [best_of(each, peer.name).score for each in entries]
        else:
            how = f"published: {peer.published}"
            found = [entry.peers[peer.name][peer.published] for entry in entries]
        rows.append(_means(peer.name, how, found, seconds))
    rows.append(_means("Denoise", "none", [entry.ours for entry in entries], seconds))
    return table(("method", "parameters", "error", "angle", "time, Denoise = 1"), rows)


def by_mesh(entries: Sequence[Entry], peers: Sequence[Peer]) -> str:
    """Auto against the best peer at its best parameter, mesh by mesh."""
    header = (
        "mesh", "vertices", "noisy", "Denoise", "best peer", "ratio", "worst class", "ratio",
        "angle", "volume", "boundary", "area", "flips", "seconds", "which peer",
    )  # fmt: skip
    rows: Rows = []
    for entry in entries:
        best, worst = best_peer(entry, peers), best_peer(entry, peers, "worst")
        own = entry.ours
        rows.append(
            [
                entry.pair.label,
                f"{len(entry.pair.clean)}",
                f"{entry.noisy['mean']:.4f}",
                f"{own['mean']:.4f}",
                f"{best.score['mean']:.4f}",
                f"{own['mean'] / best.score['mean']:.2f}",
                f"{own['worst']:.4f}",
                f"{own['worst'] / worst.score['worst']:.2f}",
                f"{own['angle']:.1f}° / {best.score['angle']:.1f}°",
                f"{_percent(own['volume'])} / {_percent(best.score['volume'])}",
                f"{_edges(own['boundary'])} / {_edges(best.score['boundary'])}",
                f"{_percent(own['area'])} / {_percent(best.score['area'])}",
                f"{own['flips']} / {best.score['flips']}",
                f"{own['seconds']:.1f}",
                f"{best.peer}, {best.parameter}",
            ]
        )
    return table(header, rows)


def by_peer(entries: Sequence[Entry], peers: Sequence[Peer]) -> str:
    """Every peer at its best parameter per mesh and at its one parameter, geometric means."""
    header = (
        "method", "mean, best parameters", "worst class", "mean, one parameter", "worst class",
        "Denoise is below on", "Denoise over it: mean", "largest", "the one parameter",
        "grid too narrow",
    )  # fmt: skip
    ours = [entry.ours for entry in entries]
    mean, worst = (geometric_mean([s[key] for s in ours]) for key in ("mean", "worst"))
    rows: Rows = [["Denoise", *[f"{mean:.4f}", f"{worst:.4f}"] * 2, *["–"] * 5]]
    for peer in peers:
        best = [best_of(entry, peer.name) for entry in entries]
        single = one_parameter(entries, peer)
        narrow = sum(peer.at_edge(point.parameter) for point in best)
        both = zip(ours, single.scores, strict=True)
        ratios = [own["mean"] / other["mean"] for own, other in both]
        rows.append(
            [
                peer.name,
                f"{geometric_mean([point.score['mean'] for point in best]):.4f}",
                f"{geometric_mean([point.score['worst'] for point in best]):.4f}",
                f"{geometric_mean([score['mean'] for score in single.scores]):.4f}",
                f"{geometric_mean([score['worst'] for score in single.scores]):.4f}",
                f"{sum(ratio < 1 for ratio in ratios)} of {len(entries)}",
                f"{geometric_mean(ratios):.2f}",
                f"{max(ratios):.2f}",
                single.parameter,
                f"{narrow} meshes" if narrow else "no",
            ]
        )
    return table(header, rows)


def by_noise(standings: dict[str, tuple[int, Standing]]) -> str:
    """Auto over the best peer by kind of noise: error / angle, geometric means."""
    header = (
        "noise", "meshes", "over one parameter", "over the best per mesh", "worst class",
        "largest error", "no more flips", "processor time",
    )  # fmt: skip
    rows = [
        [
            noise, str(count), slashed(found.fixed), slashed(found.best), f"{found.worst:.2f}",
            f"{found.largest:.2f}", f"{found.flips:.0%}", f"{found.seconds:.2g}",
        ]
        for noise, (count, found) in standings.items()
    ]  # fmt: skip
    return table(header, rows)


def of_clean(entries: Sequence[Entry]) -> str:
    """Table of the moves of meshes without noise by `denoise`."""
    rows = [
        [entry.pair.name, f"{entry.ours['moved']:.4f}", f"{entry.ours['mean']:.4f}"]
        for entry in entries
    ]
    return table(("clean mesh", "moved, in edges", "distance to the surface"), rows)


def _means(name: str, how: str, scores: Sequence[Score], seconds: Sequence[float]) -> list[str]:
    times = [score.get("seconds", np.nan) / own for score, own in zip(scores, seconds, strict=True)]
    time = geometric_mean(times)
    return [
        name,
        how,
        f"{geometric_mean([score['mean'] for score in scores]):.3f}",
        f"{np.mean([score['angle'] for score in scores]):.1f}°",
        "" if np.isnan(time) else f"{time:.2g}",
    ]


def _percent(change: float | None) -> str:
    return "–" if change is None else f"{100 * change:+.2f} %"


def _edges(length: float | None) -> str:
    return "–" if length is None else f"{length:.3f}"
