"""The table of README: `denoise` beside well-known methods, on the held-out shapes.

Smoothers in use get the parameter that is best for each mesh, which needs the clean surface to
find. Methods of the research literature run at the parameters that their authors published.

Usage: python -m benchmarks.denoising.readme_table [SHAPE ...]
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
from tqdm import tqdm

from .contest import Entry, contest
from .measures import Score
from .pairs import MAIN_NOISE, made
from .peers import PEERS, Peer
from .tables import table
from .verdict import best_of, geometric_mean

METHODS = ("MeshLab Taubin", "MeshLab two-step", "guided normals", "L0 minimisation")


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    from .shapes import GROUPS  # takes seconds, and needs the extra "bench"

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("shapes", nargs="*", metavar="SHAPE", help="default: the held-out ones")
    names = parser.parse_args(arguments).shapes or GROUPS["held-out"]
    peers = [peer.as_published for peer in PEERS if peer.name in METHODS]
    pairs = tqdm(list(made(names, [MAIN_NOISE])), unit="mesh")
    print(comparison([contest(pair, peers, None, with_auto=True) for pair in pairs], peers))


def comparison(entries: Sequence[Entry], peers: Sequence[Peer]) -> str:
    """Write means over all meshes: error and time geometric, the angle arithmetic."""
    seconds = [entry.auto["seconds"] for entry in entries]
    rows = [_row("noisy", "", [entry.noisy for entry in entries], seconds)]
    for peer in peers:
        found = [
            entry.peers[peer.name][peer.published]
            if peer.published
            else best_of(entry, peer.name).score
            for entry in entries
        ]
        how = "best for each mesh" if peer.published is None else f"published: {peer.published}"
        rows.append(_row(peer.name, how, found, seconds))
    rows.append(_row("Denoise", "none", [entry.auto for entry in entries], seconds))
    return table(("method", "parameters", "error", "angle", "time, Denoise = 1"), rows)


def _row(name: str, how: str, scores: Sequence[Score], seconds: Sequence[float]) -> list[str]:
    times = [score.get("seconds", np.nan) / own for score, own in zip(scores, seconds, strict=True)]
    time = geometric_mean(times)
    return [
        name,
        how,
        f"{geometric_mean([score['mean'] for score in scores]):.3f}",
        f"{np.mean([score['angle'] for score in scores]):.1f}°",
        "" if np.isnan(time) else f"{time:.2g}",
    ]


if __name__ == "__main__":
    main()
