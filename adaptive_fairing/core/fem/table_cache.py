"""The tables that the chunks of a mesh need, and which triangles share one."""

from __future__ import annotations

from functools import lru_cache
from itertools import groupby
from typing import NamedTuple

import numpy as np

from ..loop.basis import basis_table
from ..loop.patch_class import PatchClass
from ..loop.patches import PatchSet, Segment
from ..loop.quadrature import QuadratureChoice
from ..runtime.arrays import IndexArray, IntArray
from .class_tables import LARGEST_PRODUCT, ClassTables
from .stacked_tables import RareTables

Tables = ClassTables | RareTables

# Up to so many triangles of a class in a chunk are stacked with those of other classes, unless the
# table of a triangle has more numbers than this (200 kB), or OpenBLAS might start threads.
FEW_TRIANGLES = 3
LARGEST_STACKED = 25_000

# Tables with up to so many numbers in their products (200 kB) are kept for other meshes, so many.
LARGEST_KEPT = 25_000
MOST_KEPT = 512

# Triangles of a stack: not many, or those with few control points are filled up with many zeros.
TRIANGLES_PER_STACK = 32


class Piece(NamedTuple):
    """Triangles of a chunk with the tables that serve all of them.

    Attributes
    ----------
    tables : ClassTables or RareTables
    triangles : (n,) int
        Which triangles of the topology.
    control_points : (n_control_points, n) int32
        Vertex indices.
    """

    tables: Tables
    triangles: IndexArray
    control_points: IntArray

    def part(self, first: int, last: int) -> Piece:
        """Return the triangles `first` to `last` - 1: of rare tables none but all."""
        return Piece(self.tables, self.triangles[first:last], self.control_points[:, first:last])


class SpaceTables:
    """Tables of all classes of a mesh; those with products are made when a chunk needs them."""

    def __init__(self, patches: PatchSet, choice: QuadratureChoice) -> None:
        self._patches, self._choice = patches, choice
        self._basis = [basis_table(patch_class, choice) for patch_class in patches.classes]
        self._made: dict[int, ClassTables] = {}

    def pieces(self, segments: list[Segment]) -> list[Piece]:
        """Give every segment of a chunk its tables; rare classes are stacked."""
        pieces, rare = [], []
        for segment in segments:
            if self._is_rare(segment):
                rare.append(segment)
            else:
                pieces.append(Piece(self._of_class(segment.class_index), *segment[1:]))
        for _, group in groupby(sorted(rare, key=self._shape), lambda s: self._shape(s)[0]):
            stack: list[Segment] = []
            n_triangles = 0
            for segment in group:
                stack.append(segment)
                n_triangles += len(segment.triangles)
                if n_triangles >= TRIANGLES_PER_STACK:
                    pieces.append(self._stacked(stack))
                    stack, n_triangles = [], 0
            if stack:
                pieces.append(self._stacked(stack))
        return pieces

    def _shape(self, segment: Segment) -> tuple[int, int]:
        """Numbers of points and of control points."""
        _, n_points, n_control_points = self._basis[segment.class_index].values.shape
        return n_points, n_control_points

    def _is_rare(self, segment: Segment) -> bool:
        n_points, n_control_points = self._shape(segment)
        return (
            len(segment.triangles) <= FEW_TRIANGLES
            and 6 * n_points * n_control_points <= LARGEST_STACKED
            and n_points * n_control_points**2 <= LARGEST_PRODUCT
        )

    def _of_class(self, index: int) -> ClassTables:
        if index not in self._made:
            table = self._basis[index]
            _, n_points, n_control_points = table.values.shape
            if 2 * n_points * n_control_points * (n_control_points + 1) <= LARGEST_KEPT:
                made = _kept_tables(self._patches.classes[index], self._choice)
            else:
                made = ClassTables(table, int(self._patches.class_sizes[index]))
            self._made[index] = made
        return self._made[index]

    def _stacked(self, segments: list[Segment]) -> Piece:
        """Stack segments; triangles with fewer control points have the last one several times."""
        n_control_points = max(len(segment.control_points) for segment in segments)
        tables = [self._basis[s.class_index] for s in segments for _ in s.triangles]
        control_points = [
            s.control_points[np.minimum(np.arange(n_control_points), len(s.control_points) - 1)]
            for s in segments
        ]
        return Piece(
            RareTables(tables, n_control_points),
            np.concatenate([segment.triangles for segment in segments]),
            np.concatenate(control_points, axis=1),
        )


@lru_cache(maxsize=MOST_KEPT)
def _kept_tables(patch_class: PatchClass, choice: QuadratureChoice) -> ClassTables:
    # Products always pay here: the tables are small, and not for few triangles.
    return ClassTables(basis_table(patch_class, choice), FEW_TRIANGLES + 1)
