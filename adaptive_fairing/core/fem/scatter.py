"""Where the local matrices of a chunk go in the global one."""

from __future__ import annotations

import numpy as np

from ..linalg.symmetric_pattern import Pairs, SymmetricPattern
from ..runtime.arrays import IndexArray, IntArray
from ..runtime.threads import Workspace
from .blocks import Chunk


class ChunkEntries:
    """Where the local matrices of a chunk go.

    Attributes
    ----------
    low, high : int
        Range of the upper-triangle entries of the chunk's vertices.
    numbers : (n_entries,) int32
        Upper-triangle entry of every local matrix entry, minus `low`.
    doubled : (k,) int
        Local off-diagonal entries whose two control points are one vertex: they count twice.
    """

    def __init__(self, chunk: Chunk, pattern: SymmetricPattern, workspace: Workspace) -> None:
        self.low, self.high = pattern.row_starts[[chunk.low, chunk.high]].tolist()
        self.numbers = np.empty(chunk.n_entries, dtype=np.int32)
        places = pattern.places(chunk.low, chunk.high, workspace)
        doubled = [np.empty(0, dtype=np.intp)]
        for block in chunk.blocks:
            for group in block.groups:
                vertices, pairs = group.of_control(block.control_points), group.pairs
                places.numbers(vertices, pairs, group.of_entries(self.numbers))
                doubled.append(group.entries.start + _doubled(vertices, pairs))
        self.doubled = np.concatenate(doubled)


def _doubled(vertices: IntArray, pairs: Pairs) -> IndexArray:
    """Find the entries (a, b), a ≠ b, of local matrices (p, n), flattened, with one vertex twice.

    Parameters
    ----------
    vertices : (K, n)
    pairs : two arrays (p,)
    """
    ordered = np.sort(vertices, axis=0)
    triangles = np.flatnonzero((ordered[1:] == ordered[:-1]).any(axis=0))
    if not len(triangles):
        return triangles
    own = vertices[:, triangles]
    a, b = pairs
    found = np.flatnonzero((own[a] == own[b]) & (a != b)[:, None])
    pair, place = np.divmod(found, len(triangles))
    return pair * vertices.shape[1] + triangles[place]
