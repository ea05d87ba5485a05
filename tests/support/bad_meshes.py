"""Meshes with one thing wrong each, the same on every run: ``(vertices, faces)`` as in `meshes`."""

import numpy as np

from .meshes import Mesh, flat_grid, icosahedron, icosphere, merged, random_closed


def moebius_strip(n_segments: int = 8) -> Mesh:
    """Return a strip of 2 n triangles with one half twist: a surface with one side."""
    angle = 2 * np.pi * np.arange(n_segments) / n_segments
    vertices = np.concatenate(
        [
            np.stack(
                [
                    (2 + half * np.cos(angle / 2)) * np.cos(angle),
                    (2 + half * np.cos(angle / 2)) * np.sin(angle),
                    half * np.sin(angle / 2),
                ],
                axis=1,
            )
            for half in (-0.5, 0.5)
        ]
    )
    faces = []
    for k in range(n_segments):
        low, high, after = k, n_segments + k, (k + 1) % n_segments
        # The seam joins the lower side to the upper one.
        low_after, high_after = (
            (after, n_segments + after) if after else (n_segments + after, after)
        )
        faces += [(low, low_after, high_after), (low, high_after, high)]
    return vertices, np.array(faces, dtype=np.int32)


def klein_bottle(n: int = 6) -> Mesh:
    """Return a closed surface of n x n quads cut in two with one side, of random shape."""
    index = np.arange(n * n).reshape(n, n)
    right = np.roll(index, -1, axis=0)
    right[-1] = index[0, (-np.arange(n)) % n]  # glued in the opposite direction
    up, across = np.roll(index, -1, axis=1), np.roll(right, -1, axis=1)
    corners = (c.ravel() for c in (index, right, across, up))
    a, b, c, d = corners
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.random.default_rng(6).normal(size=(n * n, 3)), faces.astype(np.int32)


def three_sheets(n: int = 3) -> Mesh:
    """Return three half planes that share the edge from (0,0,0) to (n,0,0), n triangle edges."""
    vertices, faces = flat_grid(n, n)
    sheets = []
    spine = np.flatnonzero(vertices[:, 1] == 0)
    for turn in (0, 2 * np.pi / 3, 4 * np.pi / 3):
        x, y, _ = vertices.T
        sheets.append((np.stack([x, y * np.cos(turn), y * np.sin(turn)], axis=1), faces))
    points, triangles = merged(*sheets)
    joined = np.arange(len(points))
    for sheet in (1, 2):
        joined[spine + sheet * len(vertices)] = spine
    used, renumbered = np.unique(joined[triangles], return_inverse=True)
    return points[used], renumbered.reshape(-1, 3).astype(np.int32)


def bow_tie() -> Mesh:
    """Return two icosahedra that share one vertex, the first one."""
    one, faces = icosahedron()
    other = 2 * one[0] - one
    vertices = np.vstack([one, other[1:]])
    second = np.where(faces == 0, 0, faces + len(one) - 1)
    return vertices, np.vstack([faces, second]).astype(np.int32)


def turned(seed: int = 1, share: float = 0.3) -> Mesh:
    """Return a bumpy sphere of which some triangles run the other way round."""
    vertices, faces = random_closed(seed)
    which = np.random.default_rng(seed).random(len(faces)) < share
    faces = faces.copy()
    faces[which] = faces[which][:, ::-1]
    return vertices, faces


def collapsed(seed: int = 1) -> Mesh:
    """Return a bumpy sphere with the corners of triangle 0 in one point: 10 or more thin ones."""
    vertices, faces = random_closed(seed)
    vertices = vertices.copy()
    vertices[faces[0]] = vertices[faces[0, 0]]
    return vertices, faces


def everything_wrong() -> Mesh:
    """Return all faults together, in pieces of very different size, some on top of each other."""
    vertices, faces = icosphere(1)
    repeated = np.vstack([faces, faces[:3], faces[3:5][:, [1, 0, 2]], [(0, 0, 1), (2, 2, 2)]])
    pieces = merged(
        (vertices, repeated.astype(np.int32)),
        moebius_strip(),
        three_sheets(),
        bow_tie(),
        turned(),
        collapsed(),
        (1e-9 * vertices, faces),
        (np.zeros_like(vertices), faces),
        (1e5 * vertices, faces),
    )
    return np.vstack([pieces[0], [(1e6, 0, 0)]]), pieces[1]
