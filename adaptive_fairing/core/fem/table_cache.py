"""Cache of the tables that the chunks of a mesh need and share."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import groupby

import numpy as np

from ..loop.basis import basis_table
from ..loop.patch_class import PatchClass
from ..loop.patches import PatchSet, Segment
from ..loop.quadrature import QuadratureChoice
from .patch_tables import LARGEST_PRODUCT, PatchTables

# A matrix product for each of hundreds of classes with one or two triangles takes longer to call
# than to compute.  So in a chunk, up to so many triangles of a class are integrated together with
# those of other rare classes, each with a table of its own; unless that table has more numbers than
# this (200 kB), or OpenBLAS might start threads.
FEW_TRIANGLES = 3
LARGEST_RARE = 25_000

# Triangles of rare classes that are integrated together: with more, those with few control points
# are filled up with many zeros.
RARE_TOGETHER = 32

# Tables with up to so many numbers in their products (200 kB) are kept for other meshes, so many.
LARGEST_KEPT = 25_000
MOST_KEPT = 512


class SpaceTables:
    """Tables of all classes of a mesh; those with products are made when a chunk needs them."""

    def __init__(self, patches: PatchSet, choice: QuadratureChoice) -> None:
        self._patches, self._choice = patches, choice
        self._basis = [basis_table(patch_class, choice) for patch_class in patches.classes]
        self._made: dict[int, PatchTables] = {}

    def of_chunk(self, segments: list[Segment]) -> Iterator[tuple[PatchTables, Segment]]:
        """Give every segment of a chunk its tables; rare classes come together in segments."""
        rare = []
        for segment in segments:
            if self._is_rare(segment):
                rare.append(segment)
            else:
                yield self._of_class(segment.class_index), segment
        for _, group in groupby(sorted(rare, key=self._shape), lambda s: self._shape(s)[0]):
            together: list[Segment] = []
            for segment in group:
                together.append(segment)
                if sum(len(each.triangles) for each in together) >= RARE_TOGETHER:
                    yield self._joined(together)
                    together = []
            if together:
                yield self._joined(together)

    def _shape(self, segment: Segment) -> tuple[int, int]:
        """Numbers of points and of control points."""
        _, n_points, n_control_points = self._basis[segment.class_index].values.shape
        return n_points, n_control_points

    def _is_rare(self, segment: Segment) -> bool:
        n_points, n_control_points = self._shape(segment)
        return (
            len(segment.triangles) <= FEW_TRIANGLES
            and 6 * n_points * n_control_points <= LARGEST_RARE
            and n_points * n_control_points**2 <= LARGEST_PRODUCT
        )

    def _of_class(self, index: int) -> PatchTables:
        if index not in self._made:
            table = self._basis[index]
            _, n_points, n_control_points = table.values.shape
            if 2 * n_points * n_control_points * (n_control_points + 1) <= LARGEST_KEPT:
                made = _kept_tables(self._patches.classes[index], self._choice)
            else:
                made = PatchTables([table], int(self._patches.class_sizes[index]))
            self._made[index] = made
        return self._made[index]

    def _joined(self, segments: list[Segment]) -> tuple[PatchTables, Segment]:
        """Join segments; triangles with fewer control points have the last one several times."""
        n_control_points = max(len(segment.control_points) for segment in segments)
        control_points = [
            s.control_points[np.minimum(np.arange(n_control_points), len(s.control_points) - 1)]
            for s in segments
        ]
        tables = [self._basis[s.class_index] for s in segments for _ in s.triangles]
        triangles = np.concatenate([segment.triangles for segment in segments])
        return PatchTables(tables), Segment(-1, triangles, np.concatenate(control_points, axis=1))


@lru_cache(maxsize=MOST_KEPT)
def _kept_tables(patch_class: PatchClass, choice: QuadratureChoice) -> PatchTables:
    # A table of products of this size is worth it for any class that is not rare.
    return PatchTables([basis_table(patch_class, choice)], FEW_TRIANGLES + 1)
