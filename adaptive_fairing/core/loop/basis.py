"""The Loop basis on one triangle, evaluated and tabulated for a patch class.

The basis function of vertex i is the limit of Loop's subdivision of the unit at i.  Restricted to
one triangle, in parametric coordinates (ξ1, ξ2) with corners (0,0), (1,0), (0,1), it depends on
the connectivity around the three corners alone, so all triangles of one patch class share a table.
Subdividing a patch yields patches that are regular but for one corner each: tables are composed
from those of the children, and every point ends up in a regular patch after a few steps.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..runtime.arrays import FloatArray, IndexArray
from .box_splines import box_splines, ghost_matrix
from .fitted_quadrature import BARYCENTRIC, POINTS, fitted_weights, is_fitted
from .patch_class import PatchClass, is_regular_patch
from .quadrature import QuadratureChoice, QuadratureRule
from .subdivision import child_map, refine

# Towards a vertex of high valence rings shrink by 5/8 a subdivision instead of 1/2: the integrals
# of M there need more levels for the same accuracy.
HIGH_VALENCE = 12
EXTRA_DEPTH = 2

N_DERIVATIVES = 6  # value, ∂1, ∂2, ∂11, ∂12, ∂22


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
        return box_splines(points) @ ghost_matrix(patch_class)
    matrix, children = refine(patch_class)
    table = np.zeros((N_DERIVATIVES, len(points), matrix.shape[1]))
    bary = np.stack([1 - points.sum(axis=1), points[:, 0], points[:, 1]], axis=1)
    if bary.max(initial=0) == 1:
        raise InputError("the basis of an irregular patch cannot be evaluated at a corner itself")
    home = _home(bary)
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
    rows = table.reshape(N_DERIVATIVES, -1)
    return np.concatenate([rows[:1], first @ rows[1:3], second @ rows[3:]]).reshape(table.shape)


class BasisTable(NamedTuple):
    """Basis functions of a patch class at its quadrature points.

    Attributes
    ----------
    values : (6, n_points, n_control_points)
        Value, ∂1, ∂2, ∂11, ∂12, ∂22.
    weights : (2, n_points)
        Quadrature weights on the unit triangle, sum 1/2: for M and the measures, and for L.
    """

    values: FloatArray
    weights: FloatArray


def basis_table(patch_class: PatchClass, choice: QuadratureChoice) -> BasisTable:
    """Tabulate a patch class at the quadrature points that `choice` prescribes for it."""
    if is_regular_patch(patch_class):
        return _table_at(patch_class, choice.regular)
    if choice.prefers_fitted and is_fitted(patch_class):
        return _fitted_table(patch_class)
    return refined_table(patch_class, choice.irregular, table_depth(patch_class, choice))


def table_depth(patch_class: PatchClass, choice: QuadratureChoice) -> int:
    """Choose how often an irregular patch is refined for its quadrature points."""
    highest = max(corner.ring_size for corner in patch_class)
    return choice.depth + (EXTRA_DEPTH if highest > HIGH_VALENCE else 0)


@lru_cache(maxsize=4096)
def refined_table(patch_class: PatchClass, rule: QuadratureRule, depth: int) -> BasisTable:
    """Compose the table of a patch from those of its children, refining irregular ones."""
    if depth == 0 or is_regular_patch(patch_class):
        return _table_at(patch_class, rule)
    matrix, children = refine(patch_class)
    tables, weights = [], []
    for index, child in enumerate(children):
        part = _refined_part(child.patch_class, index, rule, depth - 1)
        tables.append(part.values @ matrix[child.rows])
        weights.append(part.weights)
    return BasisTable(np.concatenate(tables, axis=1), np.concatenate(weights, axis=1))


@lru_cache(maxsize=1024)
def _refined_part(
    child_class: PatchClass, index: int, rule: QuadratureRule, depth: int
) -> BasisTable:
    """Tabulate a child by the parameters of its parent: few children serve many classes."""
    part = refined_table(child_class, rule, depth)
    return BasisTable(_chain_rule(part.values, child_map(index)[1]), part.weights / 4)


@lru_cache(maxsize=4096)
def _table_at(patch_class: PatchClass, rule: QuadratureRule) -> BasisTable:
    weights = np.stack([rule.weights, rule.weights])
    return BasisTable(evaluate_basis(patch_class, rule.points), weights)


@lru_cache(maxsize=4096)
def _fitted_table(patch_class: PatchClass) -> BasisTable:
    """Compose a table from those of children: there are few of these, whatever the classes."""
    matrix, children = refine(patch_class)
    values = np.empty((N_DERIVATIVES, len(POINTS), matrix.shape[1]))
    for index, child in enumerate(children):
        part, inside = _fitted_part(child.patch_class, index)
        values[:, inside] = part @ matrix[child.rows]
    return BasisTable(values, fitted_weights(tuple(corner.ring_size for corner in patch_class)))


@lru_cache(maxsize=256)
def _fitted_part(child_class: PatchClass, index: int) -> tuple[FloatArray, IndexArray]:
    """Basis of a child, by parameters of its parent, at the fitted points; and which they are."""
    inside = np.flatnonzero(_home(BARYCENTRIC) == index)
    origin, jacobian = child_map(index)
    values = evaluate_basis(child_class, origin + POINTS[inside] @ jacobian.T)
    return _chain_rule(values, jacobian), inside


def _home(bary: FloatArray) -> IndexArray:
    """Find the child, 0 to 3, that each point lies in, by its barycentric coordinates (n, 3)."""
    home: IndexArray = np.where(bary.max(axis=1) > 0.5, bary.argmax(axis=1), 3)
    return home
