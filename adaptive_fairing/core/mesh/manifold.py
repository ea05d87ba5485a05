"""Cuts that turn any triangles into an oriented manifold.

The caller's mesh does not change: the result is a mesh for the solve, with copies of vertices where
surfaces were cut apart.  Those vertices are held, so that the pieces stay together.

    repeated vertex in a triangle      the triangle is left out
    the same three vertices twice      the later triangle is left out
    more than two triangles an edge    cut along the edge
    neighbours of opposite orientation turned for the solve, the smaller part of each piece
    one-sided piece (Möbius strip)     cut along the edges that cannot be made consistent
    fans that touch in one vertex      cut apart at the vertex
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components

from ..runtime.arrays import BoolArray, IntArray, LongArray
from .topology import following


@dataclass(frozen=True)
class ManifoldMesh:
    """An oriented manifold made from arbitrary triangles.

    Attributes
    ----------
    triangles : (m, 3) int
        Vertex indices in the cut mesh.
    vertex_of : (n,) int
        The caller's vertex behind each vertex of the cut mesh; each of them occurs.
    is_held : (n,) bool
        Vertices at a cut.
    left_out : (k,) int
        The caller's triangles that are not in the cut mesh.
    notes : tuple of str
        What was done, one line each, with counts.
    """

    triangles: LongArray
    vertex_of: LongArray
    is_held: BoolArray
    left_out: LongArray
    notes: tuple[str, ...]


def cut_to_manifold(faces: IntArray, n_vertices: int) -> ManifoldMesh:
    """Cut triangles apart until they form an oriented manifold.

    Parameters
    ----------
    faces : (m, 3) int
        Vertex indices, in range.
    n_vertices : int
    """
    triangles = np.asarray(faces, dtype=np.int64)
    proper, notes = _proper_triangles(triangles)
    left_out = np.setdiff1d(np.arange(len(triangles)), proper, assume_unique=True)
    triangles = triangles[proper]
    edges = _paired_edges(triangles, n_vertices)
    crowded = edges.crowded
    if len(crowded):
        notes.append(
            f"{len(crowded)} edges have more than two triangles: cut there, their vertices held"
        )
    flip, inconsistent = _orientation(edges, len(triangles))
    n_turned = int(np.count_nonzero(flip))
    if n_turned:
        triangles[flip] = triangles[flip][:, ::-1]
        notes.append(f"{n_turned} triangles were turned round, for the solve only")
        edges = _paired_edges(triangles, n_vertices)
    n_torn = int(np.count_nonzero(inconsistent))
    if n_torn:
        notes.append(f"{n_torn} edges of one-sided pieces: cut there, their vertices held")

    # Where the two half-edges still run the same way, a one-sided piece is cut.
    joined = edges.first_way != edges.second_way
    torn = np.concatenate([crowded, edges.ends[~joined]])
    corner_of, n_copies = _fans(edges, joined, triangles)
    vertex_of = np.full(n_copies, -1, dtype=np.int64)
    vertex_of[corner_of] = triangles.reshape(-1)
    loose = np.setdiff1d(np.arange(n_vertices), vertex_of, assume_unique=False)
    vertex_of = np.concatenate([vertex_of, loose])

    copies = np.bincount(vertex_of, minlength=n_vertices)
    held = copies > 1
    n_split = int(np.count_nonzero(held)) - len(np.intersect1d(np.flatnonzero(held), torn))
    if n_split:
        notes.append(f"{n_split} vertices join surfaces in a single point: cut there and held")
    held[torn.reshape(-1)] = True
    return ManifoldMesh(
        corner_of.reshape(-1, 3).astype(np.int64),
        vertex_of,
        held[vertex_of],
        left_out,
        tuple(notes),
    )


def _proper_triangles(triangles: LongArray) -> tuple[LongArray, list[str]]:
    """Triangles without a repeated vertex; of equal triangles the first."""
    notes = []
    ordered = np.sort(triangles, axis=1)
    proper = (ordered[:, 0] != ordered[:, 1]) & (ordered[:, 1] != ordered[:, 2])
    if not proper.all():
        notes.append(f"{np.count_nonzero(~proper)} triangles use one vertex twice: left out")
    candidates = np.flatnonzero(proper)
    _, first = np.unique(ordered[candidates], axis=0, return_index=True)
    if len(first) < len(candidates):
        n_equal = len(candidates) - len(first)
        notes.append(f"{n_equal} triangles repeat the vertices of another one: left out")
    return candidates[np.sort(first)], notes


@dataclass(frozen=True)
class _PairedEdges:
    """Edges with exactly two triangles, as pairs of half-edges, and the edges with more triangles.

    Attributes
    ----------
    first, second : (e,) int
        Half-edges 3 f + k.
    first_way, second_way : (e,) bool
        Whether the half-edge runs from the lower to the higher vertex.
    ends : (e, 2) int
        Vertices of the edge.
    crowded : (c, 2) int
        Vertices of the edges with more than two triangles.
    """

    first: LongArray
    second: LongArray
    first_way: BoolArray
    second_way: BoolArray
    ends: LongArray
    crowded: LongArray


def _paired_edges(triangles: LongArray, n_vertices: int) -> _PairedEdges:
    origins, targets = triangles.reshape(-1), triangles[:, [1, 2, 0]].reshape(-1)
    upward = origins < targets
    keys = np.minimum(origins, targets) * n_vertices + np.maximum(origins, targets)
    order = np.argsort(keys, kind="stable")
    unique, start, count = np.unique(keys[order], return_index=True, return_counts=True)
    ends = np.stack([unique // max(n_vertices, 1), unique % max(n_vertices, 1)], axis=1)
    pair = start[count == 2]
    first, second = order[pair], order[pair + 1]
    return _PairedEdges(
        first, second, upward[first], upward[second], ends[count == 2], ends[count > 2]
    )


def _orientation(edges: _PairedEdges, n_triangles: int) -> tuple[BoolArray, BoolArray]:
    """Triangles to turn so that neighbours agree, and the pairs that disagree even then."""
    a, b = edges.first // 3, edges.second // 3
    disagree = edges.first_way == edges.second_way
    flip = np.zeros(n_triangles, dtype=bool)
    if not disagree.any():
        return flip, disagree
    # Two sheets over every triangle, as it is and turned round: on a two-sided piece they are two
    # separate components, on a one-sided piece they are joined.
    n = n_triangles
    rows = np.concatenate([a, a + n])
    columns = np.where(np.tile(disagree, 2), np.concatenate([b + n, b]), np.concatenate([b, b + n]))
    n_sheets, sheet = connected_components(_graph(rows, columns, 2 * n), directed=False)
    as_is, turned = sheet[:n], sheet[n:]
    two_sided = as_is != turned
    # Take the one of a piece's two sheets that leaves more triangles unturned.
    n_kept = np.bincount(as_is[two_sided], minlength=n_sheets)
    kept, other = n_kept[as_is], n_kept[turned]
    flip[two_sided] = (kept < other)[two_sided] | ((kept == other) & (as_is > turned))[two_sided]
    if not two_sided.all():
        flip |= _orientation_from_seed(a, b, disagree, ~two_sided, n)
    return flip, disagree ^ flip[a] ^ flip[b]


def _orientation_from_seed(
    a: LongArray,
    b: LongArray,
    disagree: BoolArray,
    members: BoolArray,
    n_triangles: int,
) -> BoolArray:
    """Orient one-sided pieces along a breadth-first tree, so that the cut is short."""
    flip = np.zeros(n_triangles, dtype=bool)
    inside = members[a]
    graph = _graph(a[inside], b[inside], n_triangles)
    flips_across = dict(
        zip(
            zip(a[inside].tolist(), b[inside].tolist(), strict=True),
            disagree[inside].tolist(),
            strict=True,
        )
    )
    _, piece = connected_components(graph, directed=False)
    candidates = np.flatnonzero(members)
    _, seeds = np.unique(piece[candidates], return_index=True)
    for root in candidates[seeds].tolist():
        order, parent = breadth_first_order(graph, root, directed=False)
        for triangle in order[1:].tolist():
            above = int(parent[triangle])
            link = (above, triangle) if (above, triangle) in flips_across else (triangle, above)
            flip[triangle] = flip[above] ^ flips_across[link]
    return flip


def _fans(edges: _PairedEdges, joined: BoolArray, triangles: LongArray) -> tuple[LongArray, int]:
    """Find the fans of triangles around the vertices: the fan of each corner, and how many."""
    first, second = edges.first[joined], edges.second[joined]
    # The half-edges run in opposite directions: the start of one is the end of the other.
    rows = np.concatenate([first, following(first)])
    columns = np.concatenate([following(second), second])
    n_fans, fan = connected_components(_graph(rows, columns, triangles.size), directed=False)
    return fan.astype(np.int64), n_fans


def _graph(rows: LongArray, columns: LongArray, n: int) -> sparse.csr_array:
    ones = np.ones(len(rows), dtype=np.int8)
    return sparse.csr_array(sparse.coo_array((ones, (rows, columns)), shape=(n, n)))
