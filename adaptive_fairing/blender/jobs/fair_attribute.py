"""Fairing of attributes: a colour, the weights of a vertex group, a number or a vector.

The surface does not change. Colours of corners are faired by their means at the vertices. The
difference of a corner from its mean stays, so that equal corners remain equal and a seam keeps its
step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import ArrayLike, NDArray

from ...core import FairingSettings, InputError, fair_values
from ...core.runtime.arrays import FloatArray
from ..data.display import display_of
from ..data.mesh_arrays import STORAGE, integers, read_triangles
from ..data.vertex_groups import add_weights, group_weights

COLORS = ("FLOAT_COLOR", "BYTE_COLOR")
FAIRED_TYPES = ("FLOAT", "FLOAT2", "FLOAT_VECTOR", *COLORS)
"""Blender's types of attributes that can be faired."""

LEAST_WEIGHT = 1e-4
"""Least weight with which a vertex enters a group; diffusion leaves no exact 0."""


NOTICED = 1e-3
"""Excess over a limit that is reported: less than half a step of a byte colour."""


class FairedAttribute(NamedTuple):
    """Outcome of fairing an attribute: the number of values, and of those clamped at a limit.

    Finite elements have no maximum principle, so values next to a sharp step may leave the range of
    the input. Weights and byte colours are clamped to between 0 and 1.
    """

    n_values: int
    n_limited: int


def fair_attribute(
    obj: bpy.types.Object,
    name: str,
    settings: FairingSettings,
    *,
    positions: ArrayLike | None = None,
    weights: ArrayLike | None = None,
) -> FairedAttribute:
    """Fair an attribute or a vertex group on the shape that an object shows.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    name
        Name of a number, a vector or a colour at the points, of a colour at the corners, or of a
        vertex group. An attribute comes before a group of the same name.
    settings
        As in `fair_values`. The values after the last step are written.
    positions
        (n, 3) positions of the vertices; None takes those that the add-on shows.
    weights
        (n,) factors of the local time, see `fair_values`.

    Raises
    ------
    InputError
        Nothing has that name, it cannot be faired, or its values are not finite.
    FairingError
        As in `fair_values`. Nothing was written.
    """
    if obj.data.library is not None:
        raise InputError(rpt_("the mesh is linked from another file: it cannot be edited here"))
    carried = _carried(obj, name)
    before = carried.values.astype(np.float64)
    triangles = read_triangles(obj.data)
    if not len(triangles):
        raise InputError(rpt_("the mesh has no faces: there is no surface to fair on"))
    if positions is None:
        positions = display_of(obj).shown()
    positions = np.asarray(positions, dtype=np.float64)
    mean = before if carried.vertex is None else _means(before, carried.vertex, len(positions))
    faired = fair_values(positions, triangles, mean, settings, weights=weights)[-1]
    after = faired if carried.vertex is None else before + (faired - mean)[carried.vertex]
    n_limited = 0
    if carried.is_limited:
        n_limited = int((np.abs(after - 0.5) > 0.5 + NOTICED).sum())
        after = np.clip(after, 0.0, 1.0)
    carried.write(after.astype(np.float32))
    obj.data.update()
    return FairedAttribute(len(after), n_limited)


@dataclass(frozen=True)
class _Carried:
    """Numbers stored on a mesh, and a function that writes them.

    Attributes
    ----------
    values
        (n, k) at the vertices, or at the corners.
    vertex
        (n,) vertex of every corner; None at the vertices.
    is_limited
        Whether the values are within [0, 1].
    write
        Writes values of the same shape.
    """

    values: NDArray[np.float32]
    vertex: NDArray[np.int32] | None
    is_limited: bool
    write: Callable[[NDArray[np.float32]], None]


def _carried(obj: bpy.types.Object, name: str) -> _Carried:
    attribute = obj.data.attributes.get(name)
    if attribute is not None:
        return _of_attribute(obj.data, attribute)
    group = obj.vertex_groups.get(name)
    if group is not None:
        return _of_group(obj, group)
    there = [each.name for each in obj.data.attributes if _refusal(each) is None]
    there += obj.vertex_groups.keys()
    if not there:
        raise InputError(
            rpt_("there is no {!r} on the mesh, nor anything else that can be faired").format(name)
        )
    names = ", ".join(map(repr, there))
    raise InputError(rpt_("there is no {!r} on the mesh, but {:s}").format(name, names))


def _refusal(attribute: bpy.types.Attribute) -> str | None:
    """Reason why an attribute cannot be faired; None if it can."""
    if attribute.data_type not in FAIRED_TYPES or attribute.name == "position":
        return rpt_("only numbers, vectors and colors can be faired")
    if attribute.domain == "POINT":
        return None
    if attribute.domain == "CORNER" and attribute.data_type in COLORS:
        return None
    return rpt_("only values at vertices and colors of face corners can be faired")


def _of_attribute(mesh: bpy.types.Mesh, attribute: bpy.types.Attribute) -> _Carried:
    name, refusal = attribute.name, _refusal(attribute)
    if refusal is not None:
        raise InputError(f"{name!r}: {refusal}")
    data_name, width, dtype = STORAGE[attribute.data_type]
    values = np.empty((len(attribute.data), width), dtype=dtype)
    attribute.data.foreach_get(data_name, values.reshape(-1))

    def write(faired: NDArray[np.float32]) -> None:
        mesh.attributes[name].data.foreach_set(data_name, faired.ravel())

    corners = mesh.attributes[".corner_vert"].data if attribute.domain == "CORNER" else None
    vertex = None if corners is None else integers(corners, "value", 1)
    return _Carried(values, vertex, attribute.data_type == "BYTE_COLOR", write)


def _of_group(obj: bpy.types.Object, group: bpy.types.VertexGroup) -> _Carried:
    if group.lock_weight:
        raise InputError(rpt_("the vertex group {!r} is locked").format(group.name))
    before = group_weights(obj, group)

    def write(faired: NDArray[np.float32]) -> None:
        weights = faired[:, 0]
        members = np.flatnonzero((before > 0.0) | (weights >= LEAST_WEIGHT))
        add_weights(group, members, weights[members])

    return _Carried(before[:, None], None, True, write)


def _means(values: FloatArray, vertex: NDArray[np.int32], n_vertices: int) -> FloatArray:
    """Means (n, k) of the corners' values at every vertex; 0 at a vertex without a corner."""
    count = np.maximum(np.bincount(vertex, minlength=n_vertices), 1)
    sums = [np.bincount(vertex, column, n_vertices) for column in values.T]
    return np.stack(sums, axis=1) / count[:, None]
