"""One subdivision step of a patch: stencils of the refined control points, and the four children.

Sources: C. Loop 1987; on the boundary H. Biermann, A. Levin, D. Zorin 2000 without their
modification near extraordinary boundary vertices, so that boundary curves are cubic B-splines.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..mesh.loop_masks import loop_alpha
from ..runtime.arrays import FloatArray, IndexArray
from .patch_class import INTERIOR_REGULAR, ControlPoints, Corner, PatchClass, is_boundary_edge


class Child(NamedTuple):
    """One of the four triangles that a subdivision step makes of a patch.

    Attributes
    ----------
    patch_class : PatchClass
    rows : (n_control_points of the child,) int
        Its control points as rows of the refinement matrix.
    origin, jacobian : (2,), (2, 2)
        Child parameters = origin + jacobian @ parent parameters.
    """

    patch_class: PatchClass
    rows: IndexArray
    origin: FloatArray
    jacobian: FloatArray


# Children 0, 1, 2 hold the parent's corners, child 3 is the middle one.
_CHILD_MAPS = (
    ((0, 0), ((2, 0), (0, 2))),
    ((0, 2), ((0, 2), (-2, -2))),
    ((2, 0), ((-2, -2), (2, 0))),
    ((-1, 1), ((2, 2), (-2, 0))),
)


def child_map(index: int) -> tuple[FloatArray, FloatArray]:
    """Return the origin and the Jacobian of a child's parameters, see `Child`."""
    origin, jacobian = _CHILD_MAPS[index]
    return np.array(origin, dtype=np.float64), np.array(jacobian, dtype=np.float64)


@lru_cache(maxsize=4096)
def refine(patch_class: PatchClass) -> tuple[FloatArray, tuple[Child, ...]]:
    """Subdivide a patch once.

    Returns
    -------
    matrix : (n_refined, n_control_points)
        Stencils of all control points of the children: the three corners' vertex points, then the
        edge points of their spokes.
    children : four Child
    """
    control = ControlPoints(patch_class)
    rings = [control.ring(i) for i in range(3)]
    firsts = [0 if not corner.is_boundary else -corner.fan_position for corner in patch_class]
    rows = [_vertex_stencil(control, i, rings[i]) for i in range(3)]
    spoke: list[dict[int, int]] = [{}, {}, {}]
    for i in range(3):  # the patch's own edges first: entry 0 of a corner is entry 1 of the next
        spoke[i][0] = spoke[(i + 1) % 3][1] = len(rows)
        rows.append(_edge_stencil(control, i, rings[i], -firsts[i]))
    for i, corner in enumerate(patch_class):
        for place, entry in enumerate(range(firsts[i], firsts[i] + corner.ring_size)):
            if entry not in spoke[i]:
                spoke[i][entry] = len(rows)
                rows.append(_edge_stencil(control, i, rings[i], place))
        if not corner.is_boundary:
            spoke[i][-1] = spoke[i][corner.ring_size - 1]
    matrix = np.array(rows)
    matrix.setflags(write=False)
    return matrix, _children(patch_class, spoke)


def _vertex_stencil(control: ControlPoints, i: int, ring: list[int]) -> list[float]:
    """Weights of the control points in the vertex point of corner i, with this one-ring."""
    corner = control.patch_class[i]
    row = [0.0] * control.count
    if corner.is_boundary:  # cubic B-spline knot insertion along the boundary curve
        row[i] = 3 / 4
        for slot in (ring[0], ring[-1]):
            row[slot] += 1 / 8
    else:
        alpha = float(loop_alpha(corner.ring_size))
        row[i] = 1 - alpha
        for slot in ring:  # one slot may occur twice
            row[slot] += alpha / corner.ring_size
    return row


def _edge_stencil(control: ControlPoints, i: int, ring: list[int], place: int) -> list[float]:
    """Weights of the control points in the edge point from corner i to a place in its one-ring."""
    row = [0.0] * control.count
    last = len(ring) - 1
    if control.patch_class[i].is_boundary and place in (0, last):
        for slot in (i, ring[place]):
            row[slot] += 1 / 2
    else:
        for slot in (i, ring[place]):
            row[slot] += 3 / 8
        for slot in (ring[place - 1], ring[place + 1 if place < last else 0]):
            row[slot] += 1 / 8
    return row


def _children(patch_class: PatchClass, spoke: list[dict[int, int]]) -> tuple[Child, ...]:
    edge_point = [spoke[i][0] for i in range(3)]
    edge_corner: list[Corner] = []
    edge_ring: list[list[int]] = []
    for k in range(3):
        after, last = (k + 1) % 3, (k + 2) % 3
        # Counter-clockwise around the edge point, from the edge's far end on.
        ring = [after, edge_point[after], edge_point[last], k]
        if is_boundary_edge(patch_class, k):
            edge_corner.append(Corner(4, 0))
        else:
            edge_corner.append(INTERIOR_REGULAR)
            ring += [spoke[k][-1], spoke[after][2]]
        edge_ring.append(ring)

    def at_edge(k: int, offset: int) -> tuple[Corner, list[int]]:
        """Corner at edge point k whose next corner is `offset` places on in its ring."""
        corner = edge_corner[k]
        if corner.is_boundary:
            corner = Corner(4, offset)
        ring = edge_ring[k]
        return corner, [ring[(offset + entry) % len(ring)] for entry in corner.own_entries]

    children = []
    for i in range(3):
        before = (i + 2) % 3
        first = (patch_class[i], [spoke[i][entry] for entry in patch_class[i].own_entries])
        corners = [first, at_edge(i, 2), at_edge(before, 0)]
        children.append(([i, edge_point[i], edge_point[before]], corners))
    children.append((edge_point, [at_edge(k, 1) for k in range(3)]))
    result = []
    for index, (rows, corners) in enumerate(children):
        classes = (corners[0][0], corners[1][0], corners[2][0])
        own_rows = [row for _, own in corners for row in own]
        result.append(
            Child(
                classes,
                np.array(rows + own_rows, dtype=np.intp),
                *child_map(index),
            )
        )
    return tuple(result)
