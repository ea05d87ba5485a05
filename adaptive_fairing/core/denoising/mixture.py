"""Coefficients of filters at every vertex, kept as a small table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..runtime.arrays import BoolArray, FloatArray, IndexArray, IntArray, RealArray


class Mixture(NamedTuple):
    """Coefficients of k filters, which follow the density classes of each connected part.

    All coefficients at all vertices would be among the largest arrays of a run.

    Attributes
    ----------
    by_class : (p, c, k)
        Coefficients in each class of each part.
    weights : (c, n)
        Weights of the classes at the vertices, with the sum 1.
    part : (n,) int
        Part of each vertex.
    """

    by_class: FloatArray
    weights: RealArray
    part: IntArray

    @property
    def used(self) -> IndexArray:
        """Whether each filter has a coefficient other than 0 anywhere, (k,)."""
        return np.flatnonzero(self.by_class.any(axis=(0, 1)))

    def coefficients(self, index: int) -> RealArray:
        """Coefficients of one filter at the vertices, (n,)."""
        classes = self.by_class[:, :, index].astype(self.weights.dtype)
        # In most meshes there is one part, whose classes need no copy for every vertex.
        of_vertex = classes.take(self.part, axis=0) if len(classes) > 1 else classes
        coefficients: RealArray = np.einsum("cn,nc->n", self.weights, of_vertex)
        return coefficients

    def at(self, vertices: IndexArray) -> Mixture:
        """Return the same mixture for some of the vertices, by index."""
        return self._replace(weights=self.weights[:, vertices], part=self.part[vertices])

    def within(self, parts: BoolArray) -> Mixture:
        """Return the same mixture in some parts, (p,) bool; elsewhere nothing is removed."""
        return self._replace(by_class=self.by_class * parts[:, None, None])

    def spread(self, is_one: Sequence[bool]) -> Mixture:
        """Return the same mixture among k' filters; (k',) bool says which of them are its own."""
        by_class = np.zeros((*self.by_class.shape[:2], len(is_one)))
        by_class[..., is_one] = self.by_class
        return self._replace(by_class=by_class)
