"""The Loop basis on one triangle: box splines, subdivision masks, patch classes and their tables.

The basis function of vertex i is the limit of Loop's subdivision of the unit at i.  Restricted to
one triangle, in parametric coordinates (ξ1, ξ2) with corners (0,0), (1,0), (0,1), it depends on
the connectivity around the three corners alone.  That connectivity is a `PatchClass`; all
triangles of one class share one table of basis values and derivatives.

Control points of a patch, in this order: the three corners, then for corner 0, 1, 2 its one-ring
counter-clockwise without those that another entry covers.  Relative to the triangle, ring entry 0
of a corner is the next corner, entry 1 the previous one, entry 2 the vertex across the edge to the
previous one, …, entry -1 the vertex across the edge to the next one, which the next corner owns.

            o ---- 3 ---- o                 regular patch, lattice coordinates:
           / \\    / \\    / \\                 corners 0 (0,0), 1 (1,0), 2 (0,1)
          .    \\ /   \\  /   .                corner 0 owns (-1,1), (-1,0), (0,-1)
               2 ---- o                      corner 1 owns (1,-1), (2,-1), (2,0)
              / \\    /                       corner 2 owns (1,1), (0,2), (-1,2)
             0 ---- 1

Sources: C. Loop 1987 (masks); J. Stam 1998 (box splines of a regular patch); H. Biermann,
A. Levin, D. Zorin 2000 and C. Loop (boundary rules: cubic B-spline curves).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .quadrature import QuadratureChoice, QuadratureRule

FloatArray = NDArray[np.float64]

N_DERIVATIVES = 6  # value, ∂1, ∂2, ∂11, ∂12, ∂22


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
        if not self.is_boundary:
            return tuple(range(2, self.ring_size - 1))
        entries = range(-self.fan_position, self.ring_size - self.fan_position)
        return tuple(entry for entry in entries if entry not in (-1, 0, 1))


PatchClass = tuple[Corner, Corner, Corner]
INTERIOR_REGULAR = Corner(6)
REGULAR: PatchClass = (INTERIOR_REGULAR,) * 3
TETRAHEDRON: PatchClass = (Corner(3),) * 3


def loop_alpha(valence: int | NDArray[np.integer]) -> FloatArray:
    """Total weight α(n) of the one-ring in Loop's vertex rule: x' = (1 - α) x + α/n Σ x_j.

    Source: C. Loop 1987; the paper's a(n) is α(n)/n.
    """
    n = np.asarray(valence, dtype=np.float64)
    return 5 / 8 - (3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2


def limit_weight(valence: int | NDArray[np.integer]) -> FloatArray:
    """Weight l of each neighbour in the limit position (1 - n l) x + l Σ x_j.

    Source: (3.6) of the paper, l = 1 / (n + 3 / (8 a(n))) with a(n) = α(n)/n.
    """
    n = np.asarray(valence, dtype=np.float64)
    return 1 / (n + 3 * n / (8 * loop_alpha(n)))


# --- Control points of a patch class -------------------------------------------------------------


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


def is_boundary_edge(patch_class: PatchClass, corner: int) -> bool:
    """Whether the edge from `corner` to the next corner lies on the boundary."""
    return patch_class[corner].fan_position == 0


# --- One subdivision step ------------------------------------------------------------------------


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
    rows: NDArray[np.intp]
    origin: FloatArray
    jacobian: FloatArray


# Children 0, 1, 2 hold the parent's corners, child 3 is the middle one.
_CHILD_MAPS = (
    ((0, 0), ((2, 0), (0, 2))),
    ((0, 2), ((0, 2), (-2, -2))),
    ((2, 0), ((-2, -2), (2, 0))),
    ((-1, 1), ((2, 2), (-2, 0))),
)


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
    rows: list[FloatArray] = []
    spoke: list[dict[int, int]] = [{}, {}, {}]
    for i in range(3):
        rows.append(_vertex_stencil(control, i))
    for i in range(3):  # the patch's own edges first: entry 0 of a corner is entry 1 of the next
        spoke[i][0] = spoke[(i + 1) % 3][1] = len(rows)
        rows.append(_edge_stencil(control, i, 0))
    for i, corner in enumerate(patch_class):
        first = 0 if not corner.is_boundary else -corner.fan_position
        for entry in range(first, first + corner.ring_size):
            if entry not in spoke[i]:
                spoke[i][entry] = len(rows)
                rows.append(_edge_stencil(control, i, entry))
        if not corner.is_boundary:
            spoke[i][-1] = spoke[i][corner.ring_size - 1]
    matrix = np.array(rows)
    matrix.setflags(write=False)
    return matrix, _children(patch_class, spoke)


def _vertex_stencil(control: ControlPoints, i: int) -> FloatArray:
    corner = control.patch_class[i]
    ring = control.ring(i)
    row = np.zeros(control.count)
    if corner.is_boundary:  # cubic B-spline knot insertion along the boundary curve
        row[i] = 3 / 4
        np.add.at(row, [ring[0], ring[-1]], 1 / 8)
    else:
        alpha = float(loop_alpha(corner.ring_size))
        row[i] = 1 - alpha
        np.add.at(row, ring, alpha / corner.ring_size)
    return row


def _edge_stencil(control: ControlPoints, i: int, entry: int) -> FloatArray:
    corner = control.patch_class[i]
    row = np.zeros(control.count)
    on_boundary = corner.is_boundary and entry + corner.fan_position in (0, corner.ring_size - 1)
    if on_boundary:
        np.add.at(row, [i, control.slot(i, entry)], 1 / 2)
    else:
        np.add.at(row, [i, control.slot(i, entry)], 3 / 8)
        np.add.at(row, [control.slot(i, entry - 1), control.slot(i, entry + 1)], 1 / 8)
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
    for (rows, corners), (origin, jacobian) in zip(children, _CHILD_MAPS, strict=True):
        classes = (corners[0][0], corners[1][0], corners[2][0])
        own_rows = [row for _, own in corners for row in own]
        result.append(
            Child(
                classes,
                np.array(rows + own_rows, dtype=np.intp),
                np.array(origin, dtype=np.float64),
                np.array(jacobian, dtype=np.float64),
            )
        )
    return tuple(result)


# --- Box splines of a regular patch --------------------------------------------------------------


def _box_spline_coefficients() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Exponents (15, 3) and integer coefficients (12, 15), common factor 1/12.

    In barycentric coordinates (u, v, w) of the triangle the twelve quartic box splines are three
    polynomials up to symmetry: that of a corner, of the vertex across an edge, and of a tip.
    Source: J. Stam 1998, appendix A.
    """
    at_u = {
        (4, 0, 0): 6, (3, 1, 0): 24, (3, 0, 1): 24, (2, 2, 0): 24, (2, 1, 1): 60, (2, 0, 2): 24,
        (1, 3, 0): 8, (1, 2, 1): 36, (1, 1, 2): 36, (1, 0, 3): 8,
        (0, 4, 0): 1, (0, 3, 1): 6, (0, 2, 2): 12, (0, 1, 3): 6, (0, 0, 4): 1,
    }  # fmt: skip
    across_uw = {
        (4, 0, 0): 1, (3, 0, 1): 6, (2, 0, 2): 12, (1, 0, 3): 6, (0, 0, 4): 1,
        (3, 1, 0): 2, (2, 1, 1): 6, (1, 1, 2): 6, (0, 1, 3): 2,
    }  # fmt: skip
    tip_w = {(4, 0, 0): 1, (3, 0, 1): 2}
    tip_v = {(4, 0, 0): 1, (3, 1, 0): 2}

    exponents = sorted(at_u)
    coefficients = np.zeros((12, 15), dtype=np.int64)
    for corner in range(3):
        # Ring entries 2, 3, 4 of a corner: across the edge to the previous corner, then the tips.
        for slot, polynomial in zip(
            (corner, 3 + 3 * corner, 4 + 3 * corner, 5 + 3 * corner),
            (at_u, across_uw, tip_w, tip_v),
            strict=True,
        ):
            for exponent, value in polynomial.items():
                rotated = tuple(exponent[(k - corner) % 3] for k in range(3))
                coefficients[slot, exponents.index(rotated)] = value
    return np.array(exponents), coefficients


_EXPONENTS, _COEFFICIENTS = _box_spline_coefficients()


def box_splines(points: FloatArray) -> FloatArray:
    """Evaluate the twelve box splines of a regular patch and their derivatives.

    Parameters
    ----------
    points : (n_points, 2)

    Returns
    -------
    (6, n_points, 12)
        Value, ∂1, ∂2, ∂11, ∂12, ∂22.
    """
    points = np.asarray(points, dtype=np.float64)
    bary = np.stack([1 - points.sum(axis=1), points[:, 0], points[:, 1]], axis=1)
    powers = bary[:, :, None] ** np.arange(5)

    def monomials(derivative: tuple[int, int, int]) -> FloatArray:
        product = np.ones((len(points), len(_EXPONENTS)))
        for axis, order in enumerate(derivative):
            exponent = _EXPONENTS[:, axis]
            factor = np.ones(len(exponent))
            for k in range(order):
                factor = factor * (exponent - k)
            product *= factor * powers[:, axis, np.maximum(exponent - order, 0)]
        return product

    # ∂1 = ∂v - ∂u and ∂2 = ∂w - ∂u, because u = 1 - ξ1 - ξ2.
    u, v, w = monomials((1, 0, 0)), monomials((0, 1, 0)), monomials((0, 0, 1))
    uu, vv, ww = monomials((2, 0, 0)), monomials((0, 2, 0)), monomials((0, 0, 2))
    uv, uw, vw = monomials((1, 1, 0)), monomials((1, 0, 1)), monomials((0, 1, 1))
    stacked = np.stack(
        [
            monomials((0, 0, 0)),
            v - u,
            w - u,
            vv - 2 * uv + uu,
            vw - uv - uw + uu,
            ww - 2 * uw + uu,
        ]
    )
    return stacked @ (_COEFFICIENTS.T / 12)


def _ghost_matrix(patch_class: PatchClass) -> FloatArray:
    """Express the 12 control points of a regular patch by those that exist, (12, n).

    Beyond a boundary edge (a, b) with third vertex c stands the ghost a + b - c; with it the box
    spline's own rules reproduce Loop's boundary rules exactly.
    """
    control = ControlPoints(patch_class)
    matrix = np.zeros((12, control.count))
    matrix[:3, :3] = np.eye(3)
    for i, corner in enumerate(patch_class):
        for k, entry in enumerate((2, 3, 4)):
            row = matrix[3 + 3 * i + k]
            if not corner.is_boundary:
                row[control.slot(i, entry)] += 1
                continue
            ring = control.ring(i)
            place = (corner.fan_position + entry) % 6
            if place < 4:
                row[ring[place]] += 1
            else:
                end, inner = (ring[3], ring[2]) if place == 4 else (ring[0], ring[1])
                np.add.at(row, [i, end], 1)
                row[inner] -= 1
    return matrix


# --- Evaluation ----------------------------------------------------------------------------------


def is_regular_patch(patch_class: PatchClass) -> bool:
    """Whether the patch is one polynomial: every corner regular, inside or on the boundary."""
    return all(corner.is_regular for corner in patch_class)


def evaluate_basis(patch_class: PatchClass, points: FloatArray) -> FloatArray:
    """Evaluate all basis functions of a patch and their derivatives.

    Parameters
    ----------
    patch_class : PatchClass
    points : (n_points, 2)
        Parametric coordinates; not on an extraordinary corner itself, where second derivatives
        do not exist.

    Returns
    -------
    (6, n_points, n_control_points)
        Value, ∂1, ∂2, ∂11, ∂12, ∂22.
    """
    points = np.asarray(points, dtype=np.float64)
    if is_regular_patch(patch_class):
        return box_splines(points) @ _ghost_matrix(patch_class)
    matrix, children = refine(patch_class)
    table = np.zeros((N_DERIVATIVES, len(points), matrix.shape[1]))
    bary = np.stack([1 - points.sum(axis=1), points[:, 0], points[:, 1]], axis=1)
    if bary.max(initial=0) == 1:
        raise InputError("the basis of an irregular patch cannot be evaluated at a corner itself")
    home = np.where(bary.max(axis=1) > 0.5, bary.argmax(axis=1), 3)
    for index, child in enumerate(children):
        inside = np.flatnonzero(home == index)
        if len(inside):
            local = child.origin + points[inside] @ child.jacobian.T
            part = evaluate_basis(child.patch_class, local) @ matrix[child.rows]
            table[:, inside] = _chain_rule(part, child.jacobian)
    return table


def _chain_rule(table: FloatArray, jacobian: FloatArray) -> FloatArray:
    """Turn derivatives by child parameters into derivatives by parent parameters."""
    (a, b), (c, d) = jacobian
    first = np.array([[a, c], [b, d]])
    second = np.array(
        [
            [a * a, 2 * a * c, c * c],
            [a * b, a * d + b * c, c * d],
            [b * b, 2 * b * d, d * d],
        ]
    )
    result = np.empty_like(table)
    result[0] = table[0]
    result[1:3] = np.tensordot(first, table[1:3], axes=1)
    result[3:6] = np.tensordot(second, table[3:6], axes=1)
    return result


class BasisTable(NamedTuple):
    """Basis functions of a patch class at its quadrature points.

    Attributes
    ----------
    values : (6, n_points, n_control_points)
        Value, ∂1, ∂2, ∂11, ∂12, ∂22.
    weights : (n_points,)
        Quadrature weights on the unit triangle, sum 1/2.
    """

    values: FloatArray
    weights: FloatArray


@lru_cache(maxsize=4096)
def basis_table(patch_class: PatchClass, choice: QuadratureChoice) -> BasisTable:
    """Tabulate a patch class at the quadrature points that `choice` prescribes for it."""
    if is_regular_patch(patch_class):
        return _table_at(patch_class, choice.regular)
    return _refined_table(patch_class, choice.irregular, choice.depth)


@lru_cache(maxsize=4096)
def _refined_table(patch_class: PatchClass, rule: QuadratureRule, depth: int) -> BasisTable:
    """Compose the table of a patch from those of its children, refining irregular ones."""
    if depth == 0 or is_regular_patch(patch_class):
        return _table_at(patch_class, rule)
    matrix, children = refine(patch_class)
    tables, weights = [], []
    for child in children:
        part = _refined_table(child.patch_class, rule, depth - 1)
        tables.append(_chain_rule(part.values @ matrix[child.rows], child.jacobian))
        weights.append(part.weights / 4)
    return BasisTable(np.concatenate(tables, axis=1), np.concatenate(weights))


@lru_cache(maxsize=4096)
def _table_at(patch_class: PatchClass, rule: QuadratureRule) -> BasisTable:
    return BasisTable(evaluate_basis(patch_class, rule.points), rule.weights)
