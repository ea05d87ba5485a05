"""One picture per mesh: noisy, ours, peers and clean, whole and where they differ most."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tools.geometry.triangles import FloatArray, local_edge_lengths, vertex_normals

from .contest import Entry
from .measures import Reference, Score
from .ours import denoised
from .peers import Peer
from .verdict import best_peer

VIEWS = ((0.5, -1, 0.6), (-0.8, -0.7, 0.5), (0.8, 0.7, 0.5), (-0.6, 0.9, 0.5), (0.3, -0.5, -0.9))
"""Towards the camera; of these, the one that sees the place of the close-up best is taken."""

BESIDE = ("guided normals", "L0 minimisation")
"""Research peers that are shown."""

CLOSE = 10
"""Half the width of a close-up, in local edges of its place."""

WHOLE_SIZE, CLOSE_SIZE, SAMPLES = (430, 360), (430, 400), 6


def picture(entry: Entry, peers: Sequence[Peer], folder: Path) -> Path:
    """Render the meshes side by side, flat shaded, into FOLDER/LABEL.png.

    Beside ours the best of the peers at its best parameter; but where guided filtering and L0
    minimisation are among the peers, these two, at the parameters of their authors.
    """
    from research.figures.layout import Panel, Shot, figure
    from research.figures.render import View

    pair = entry.pair
    by_name = {peer.name: peer for peer in peers}
    shown = [
        (name, by_name[name].published, entry.peers[name][by_name[name].published])
        for name in BESIDE
        if name in by_name
    ] or [best_peer(entry, peers)]
    theirs = [by_name[name].result(pair.noisy, pair.faces, value) for name, value, _ in shown]
    ours = denoised(pair.noisy, pair.faces)
    vertex = _most_different(Reference(pair.clean, pair.faces), ours, theirs[0])
    normal = vertex_normals(pair.clean, pair.faces)[vertex]
    reach = CLOSE * local_edge_lengths(pair.clean, pair.faces)[vertex]
    place = pair.clean[vertex]
    whole = max(VIEWS, key=lambda view: np.dot(view, normal) / np.linalg.norm(view))
    close = View(tuple(_slanted(normal)), box=(place - reach, place + reach), margin=0.0)
    shots = [[Shot(View(whole), WHOLE_SIZE), Shot(close, CLOSE_SIZE)]]
    panels = [
        Panel(pair.noisy, f"{pair.label}: noisy", _text(entry.noisy)),
        Panel(ours, "Denoise", _text(entry.ours)),
        *(
            Panel(positions, name, _text(score))
            for positions, (name, _, score) in zip(theirs, shown, strict=True)
        ),
        Panel(pair.clean, "clean", "below: where Denoise and the first peer differ most"),
    ]
    path = folder / f"{pair.label.replace(':', '_')}.png"
    figure(path, [panels], pair.faces, shots, SAMPLES)
    return path


def _most_different(reference: Reference, ours: FloatArray, theirs: FloatArray) -> int:
    """Return the vertex around which the squared errors differ most, averaged over its region."""
    mine, other = (np.square(reference.distances(each)).sum(axis=0) for each in (ours, theirs))
    used = np.unique(reference.faces)
    smooth = np.zeros(len(reference.vertices))
    smooth[used] = mine - other
    first, second = reference.faces, reference.faces[:, [1, 2, 0]]
    valence = np.bincount(first.ravel(), minlength=len(smooth)) + 1
    for _ in range(12):
        total = smooth + np.bincount(first.ravel(), smooth[second].ravel(), len(smooth))
        smooth = total / valence
    return int(np.argmax(np.abs(smooth)))


def _slanted(normal: FloatArray) -> FloatArray:
    """Look along the surface a little, as relief shows best."""
    side = np.cross(normal, [0.0, 0.0, 1.0] if abs(normal[2]) < 0.8 else [0.0, 1.0, 0.0])
    return normal + 0.35 * side / np.linalg.norm(side)


def _text(score: Score) -> str:
    return f"error {score['mean']:.3f}, angle {score['angle']:.1f}°"
