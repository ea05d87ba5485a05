r"""Patch classes: the connectivity around a triangle that its Loop basis functions depend on.

The control points of a patch are, in this order, the three corners, then for corner 0, 1, 2 its
one-ring counter-clockwise without those that another entry covers.  Relative to the triangle, ring
entry 0 of a corner is the next corner, entry 1 the previous one, entry 2 the vertex across the
edge to the previous one, …, entry -1 the vertex across the edge to the next one, which the next
corner owns.  A regular patch:

            11 --- 10
            / \   / \
           3 --- 2 --- 9
          / \   / \   / \
         4 --- 0 --- 1 --- 8
          \   / \   / \   /
           5 --- 6 --- 7
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple


class Corner(NamedTuple):
    """Connectivity around one corner of a triangle.

    Attributes
    ----------
    ring_size : int
        Number of neighbours of the corner vertex.
    fan_position : int
        -1 for an interior vertex.  For a boundary vertex: the triangle's place in the fan of
        ring_size - 1 triangles, counted counter-clockwise from 0.
    """

    ring_size: int
    fan_position: int = -1

    @property
    def is_boundary(self) -> bool:
        """Whether the corner vertex lies on the boundary."""
        return self.fan_position >= 0

    @property
    def is_regular(self) -> bool:
        """Whether the surface is a box spline near this corner (with extrapolated ghosts)."""
        return self.ring_size == (4 if self.is_boundary else 6)

    @property
    def own_entries(self) -> tuple[int, ...]:
        """Ring entries, relative to the triangle, that this corner adds to the control points."""
        return _own_entries(self)


@lru_cache(maxsize=4096)
def _own_entries(corner: Corner) -> tuple[int, ...]:
    if not corner.is_boundary:
        return tuple(range(2, corner.ring_size - 1))
    entries = range(-corner.fan_position, corner.ring_size - corner.fan_position)
    return tuple(entry for entry in entries if entry not in (-1, 0, 1))


PatchClass = tuple[Corner, Corner, Corner]
INTERIOR_REGULAR = Corner(6)
TETRAHEDRON: PatchClass = (Corner(3),) * 3


def is_regular_patch(patch_class: PatchClass) -> bool:
    """Whether the patch is one polynomial: every corner regular, inside or on the boundary."""
    return all(corner.is_regular for corner in patch_class)


class ControlPoints:
    """Numbering of a patch class's control points: which one is ring entry j of corner i."""

    def __init__(self, patch_class: PatchClass) -> None:
        self.patch_class = patch_class
        self._slots: list[dict[int, int]] = []
        count = 3
        for corner in patch_class:
            self._slots.append({entry: count + k for k, entry in enumerate(corner.own_entries)})
            count += len(corner.own_entries)
        self.count = 4 if patch_class == TETRAHEDRON else count

    def slot(self, corner: int, entry: int) -> int:
        """Return the control point that is ring entry `entry` (relative) of corner `corner`."""
        ring_size, fan_position = self.patch_class[corner]
        if fan_position < 0:
            entry %= ring_size
        if entry in (0, 1):
            return (corner + 1 + entry) % 3
        if entry in self._slots[corner]:
            return self._slots[corner][entry]
        if self.patch_class == TETRAHEDRON:
            return 3
        # The vertex across the edge to the next corner.  A corner of valence 3 has none of its
        # own: both edges see the same vertex, and a neighbouring corner owns it.
        return self.slot((corner + 1) % 3, 2)

    def ring(self, corner: int) -> list[int]:
        """Control points of a corner's whole one-ring, from its first entry on."""
        ring_size, fan_position = self.patch_class[corner]
        first = 0 if fan_position < 0 else -fan_position
        return [self.slot(corner, first + k) for k in range(ring_size)]


@lru_cache(maxsize=4096)
def count_control_points(patch_class: PatchClass) -> int:
    """Count the control points of a patch."""
    return ControlPoints(patch_class).count


def is_boundary_edge(patch_class: PatchClass, corner: int) -> bool:
    """Whether the edge from `corner` to the next corner lies on the boundary."""
    return patch_class[corner].fan_position == 0
