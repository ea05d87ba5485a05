"""Contest of all methods on one pair; scores are kept per version of peer and of ours."""

from __future__ import annotations

import hashlib
import json
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .measures import Reference, Score
from .ours import OURS
from .pairs import Pair
from .peers import Peer

HOPELESS = 2.5
"""A sweep ends where its error is this many times its least: it only gets worse from there."""

MEASURES_VERSION = 4
"""Part of what is kept: to be raised when `measures` or a peer's own code changes."""

Scores = dict[str, Score]
"""By parameter."""


def peer_scores(pair: Pair, peer: Peer, cache: Path | None = None) -> Scores:
    """Score a peer at every point of its grid, or as far as it makes sense.

    Parameters
    ----------
    pair, peer
        What is smoothed by what.
    cache
        Folder in which scores are kept from run to run.

    Returns
    -------
    dict
        `Score` by parameter, with the processor time as "seconds". A result that is not finite is
        left out.
    """
    kept = _file(pair, peer, cache)
    if kept is not None and kept.is_file():
        return json.loads(kept.read_text())
    scores = _scored(pair, peer)
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        partial = kept.with_suffix(".partial")
        partial.write_text(json.dumps(scores))
        partial.replace(kept)
    return scores


def _scored(pair: Pair, peer: Peer) -> Scores:
    reference = Reference(pair.clean, pair.faces)
    scores: Scores = {}
    for variant, options in peer.variants.items():
        least, seconds = np.inf, 0.0
        found = peer.run(pair.noisy, pair.faces, peer.sweep, **options)
        for value in peer.sweep:
            start = time.process_time()
            positions = next(found)
            seconds = seconds * peer.goes_on + time.process_time() - start
            if not np.isfinite(positions).all():
                break
            score = reference.score(positions) | {"seconds": seconds}
            scores[peer.parameter(variant, value)] = score
            least = min(least, score["mean"])
            if score["mean"] > HOPELESS * least and peer.published is None:
                break
    return scores


def _file(pair: Pair, peer: Peer, cache: Path | None) -> Path | None:
    if cache is None:
        return None
    grid = repr((peer.sweep, peer.variants, MEASURES_VERSION))
    digest = hashlib.sha256(grid.encode()).hexdigest()[:10]
    name = re.sub(r"[^\w.]+", "_", f"{peer.name} {peer.version} {digest}")
    return cache / pair.digest / f"{name}.json"


@dataclass(frozen=True)
class Entry:
    """All scores on one pair.

    Attributes
    ----------
    pair
        The mesh.
    noisy
        Score of the noisy mesh as it is.
    ours
        Score of `denoise`.
    peers
        By name, the scores at all parameters.
    """

    pair: Pair
    noisy: Score
    ours: Score
    peers: Mapping[str, Scores]


def contest(pair: Pair, peers: Sequence[Peer], cache: Path | None) -> Entry:
    """Score the noisy mesh, Denoise and all peers on one pair."""
    reference = Reference(pair.clean, pair.faces)
    score = peer_scores(pair, OURS, cache)[OURS.parameter("", 1.0)]
    found = {peer.name: peer_scores(pair, peer, cache) for peer in peers}
    return Entry(pair, reference.score(pair.noisy), score, found)
