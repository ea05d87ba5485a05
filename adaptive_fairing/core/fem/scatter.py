"""Scatter of the chunks' local matrices into the global one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..linalg.symmetric_pattern import Pairs, SymmetricPattern
from ..loop.partition import triangle_slabs
from ..runtime.arrays import IndexArray, IntArray
from ..runtime.threads import Workspace, for_each, ordered_map
from .blocks import Chunk


class ChunkEntries(NamedTuple):
    """Global entries for the local matrices of a chunk.

    Attributes
    ----------
    low, high : int
        Range of the upper-triangle entries of the chunk's vertices.
    numbers : (n_entries,) int32
        Upper-triangle entry of every local matrix entry, minus `low`.
    doubled : (k,) int
        Local off-diagonal entries whose two control points are one vertex: they count twice.
    """

    low: int
    high: int
    numbers: IntArray
    doubled: IndexArray


def entries_of_chunks(
    chunks: list[Chunk], n_triangles: int, pattern: SymmetricPattern
) -> list[ChunkEntries]:
    """Find the entries of all chunks of a mesh, slab by slab.

    The vertices of a slab are few enough for a table of their entries.
    """
    numbers = [np.empty(chunk.n_entries, dtype=np.int32) for chunk in chunks]
    lows, highs = pattern.row_starts[[[c.low for c in chunks], [c.high for c in chunks]]].tolist()
    # A workspace of its own: its large tables are not needed again.
    workspace = Workspace()

    def look_up(slab: slice) -> None:
        parts = [
            part
            for each in zip(chunks, numbers, lows, strict=True)
            for part in _parts_in_slab(*each, slab)
        ]
        low = min(int(part.vertices.min()) for part in parts)
        high = max(int(part.vertices.max()) for part in parts) + 1
        places = pattern.places(low, high, workspace)
        for part in parts:
            vertices = part.vertices - np.int32(low)
            if part.is_whole:
                places.numbers(vertices, part.pairs, part.first, out=part.numbers)
            else:
                found = np.empty((len(part.numbers), len(part.columns)), dtype=np.int32)
                places.numbers(vertices, part.pairs, part.first, out=found)
                part.numbers[:, part.columns] = found

    for_each(look_up, triangle_slabs(n_triangles))
    doubled = ordered_map(lambda each: _doubled(*each), list(zip(chunks, numbers, strict=True)))
    return [ChunkEntries(*each) for each in zip(lows, highs, numbers, doubled, strict=True)]


class _Part(NamedTuple):
    """The triangles of a group that lie in a slab.

    Attributes
    ----------
    vertices : (K, n) int32
        Their control points; a copy.
    pairs : two arrays (p,)
    numbers : (p, n_group) int32
        Entries of the whole group, to be filled in.
    columns : (n,) int
        The part's triangles among those of the group.
    first : int
        Entry from which numbers are counted.
    """

    vertices: IntArray
    pairs: Pairs
    numbers: IntArray
    columns: IndexArray
    first: int

    @property
    def is_whole(self) -> bool:
        """Whether the part is the whole group."""
        return len(self.columns) == self.numbers.shape[1]


def _parts_in_slab(chunk: Chunk, numbers: IntArray, low: int, slab: slice) -> Iterator[_Part]:
    """Find what a chunk has in a slab: most chunks lie in one, those of uncommon classes do not."""
    for block in chunk.blocks:
        inside = (block.triangles >= slab.start) & (block.triangles < slab.stop)
        if not inside.any():
            continue
        for group in block.groups:
            columns = np.flatnonzero(inside[group.columns])
            if len(columns):
                vertices = group.of_control(block.control_points)[:, columns]
                yield _Part(
                    vertices + np.int32(chunk.low),
                    group.pairs,
                    group.of_entries(numbers),
                    columns,
                    low,
                )


def _doubled(chunk: Chunk, numbers: IntArray) -> IndexArray:
    """Find the local entries (a, b), a ≠ b, with one vertex twice: those that go where (a, a) goes.

    Parameters
    ----------
    chunk : Chunk
    numbers : (n_entries,)
        Where its local entries go.
    """
    found = [np.empty(0, dtype=np.intp)]
    for block in chunk.blocks:
        for group in block.groups:
            a, b = group.pairs
            own = group.of_entries(numbers)
            same = own == own[a == b][a]
            same[a == b] = False
            found.append(group.entries.start + np.flatnonzero(same))
    return np.concatenate(found)
