"""Refined mesh in one piece, with the transfer of values from the caller's mesh.

An edge point gets the mean of the two values at its ends, rounded for whole numbers.  A flag is
true there if it is true at both ends; anything else is taken from the first end.  Children of a
triangle inherit its values, halves of an edge those of the edge.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import BoolArray, LongArray
from ..runtime.lazy import cached_property
from .cut_surface import CutSurface
from .refined_topology import RefinedTopology, edge_keys

Values = NDArray[Any]


class RefinedNet:
    """Vertices, edges and triangles after `levels` steps, joined where the caller's mesh is.

    Parameters
    ----------
    cut : CutSurface
    levels : int

    Attributes
    ----------
    triangles : (m, 3) int
        In the caller's orientation.
    edges : (e, 2) int
    sides : (m, 3) int
        Edge from corner k of a triangle to corner k + 1.
    """

    def __init__(self, cut: CutSurface, levels: int) -> None:
        self.cut = cut
        self.levels = levels
        mesh = cut.levels.mesh(levels)
        self.triangles: Values = mesh.triangles
        self.sides: Values = mesh.sides
        self.edges: Values = mesh.edges
        if not cut.is_cut:
            return
        number = cut.joined_vertices(levels)
        ends = number[mesh.edges]
        _, self._edge_choice, edge_number = np.unique(
            edge_keys(ends, int(number.max()) + 1), return_index=True, return_inverse=True
        )
        self.edges = ends[self._edge_choice]
        turned = self._is_turned
        self.triangles = number[mesh.triangles]
        self.sides = edge_number.reshape(-1)[mesh.sides]
        self.triangles[turned] = self.triangles[turned, ::-1]
        self.sides[turned] = self.sides[turned][:, [1, 0, 2]]

    @cached_property
    def _vertex_choice(self) -> LongArray:
        """One of the copies of every vertex."""
        choice: LongArray = np.unique(self.cut.joined_vertices(self.levels), return_index=True)[1]
        return choice

    @cached_property
    def _is_turned(self) -> BoolArray:
        """Refined triangles that run the other way in the surface."""
        return np.repeat(self.cut.is_turned, 4**self.levels)

    @property
    def n_vertices(self) -> int:
        """Number of vertices, the caller's loose ones included."""
        return len(self._vertex_choice) if self.cut.is_cut else self._mesh(self.levels).n_vertices

    def joined(self, values: Values) -> Values:
        """Take values at the surface's vertices, such as limit positions, to the net's vertices."""
        return values[self._vertex_choice] if self.cut.is_cut else values

    def corner_normals(self, normals: Values) -> Values:
        """Take normals (m, 3, 3) at the surface's triangle corners to those of the net."""
        if self.cut.is_turned.any():
            normals = normals.copy()
            normals[self._is_turned] = -normals[self._is_turned, ::-1]
        return normals

    def of_points(self, values: Values) -> Values:
        """Refine values (n, …) of the caller's vertices."""
        values = values[self.cut.vertex_of] if self.cut.is_cut else values
        for level in range(self.levels):
            ends = self._mesh(level).edges
            values = np.concatenate([values, _half_way(values[ends[:, 0]], values[ends[:, 1]])])
        return self.joined(values)

    def of_corners(self, values: Values) -> Values:
        """Refine values (3 m, …) of the caller's triangle corners, to (3 · 4^levels m, …)."""
        corners = values[self.cut.corner_of]
        for _ in range(self.levels):
            middles = _half_way(corners, corners[:, [1, 2, 0]])
            children = np.empty((len(corners), 4, 3, *corners.shape[2:]), dtype=corners.dtype)
            children[:, :3, 0] = corners
            children[:, :3, 1] = children[:, 3] = middles
            children[:, :3, 2] = middles[:, [2, 0, 1]]
            corners = children.reshape(-1, *children.shape[2:])
        if self.cut.is_turned.any():
            corners[self._is_turned] = corners[self._is_turned, ::-1]
        return corners.reshape(-1, *corners.shape[2:])

    def of_triangles(self, values: Values) -> Values:
        """Pass values (m, …) of the caller's triangles on to their children."""
        return np.repeat(values[self.cut.corner_of[:, 0] // 3], 4**self.levels, axis=0)

    def of_edges(self, values: Values, ends: LongArray, default: object) -> Values:
        """Pass values (k, …) of the caller's edges on to their parts.

        Parameters
        ----------
        values : (k, …)
        ends : (k, 2) int
            The caller's vertices of the edges.
        default : object
            Value of the edges inside the caller's triangles.
        """
        n = len(self.cut.vertex_of)
        own = edge_keys(self.cut.vertex_of[self._mesh(0).edges], n)
        keys = edge_keys(ends, n)
        order = np.argsort(keys)
        place = np.minimum(np.searchsorted(keys, own, sorter=order), max(len(keys) - 1, 0))
        current = np.full((len(own), *values.shape[1:]), default, dtype=values.dtype)
        if len(keys):
            found = keys[order[place]] == own
            current[found] = values[order[place[found]]]
        for level in range(self.levels):
            inner = np.full((self._mesh(level).triangles.size, *current.shape[1:]), default)
            halves = np.repeat(current, 2, axis=0)
            current = np.concatenate([halves, inner.astype(current.dtype)])
        return current[self._edge_choice] if self.cut.is_cut else current

    def _mesh(self, level: int) -> RefinedTopology:
        return self.cut.levels.mesh(level)


def _half_way(first: Values, second: Values) -> Values:
    if first.dtype == bool:
        both: Values = first & second
        return both
    if first.dtype.kind == "f":
        mean: Values = (first + second) * first.dtype.type(0.5)
        return mean
    if first.dtype.kind in "iu":
        whole: Values = np.rint((first.astype(np.float64) + second) / 2).astype(first.dtype)
        return whole
    return first
