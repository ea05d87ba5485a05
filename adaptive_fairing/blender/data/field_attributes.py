"""Numbers per vertex as attributes of the mesh: the value, and its colour."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .attribute_arrays import remove_attributes
from .color_map import ANCHORS, color_range, colors_srgb, srgb_to_linear

DENSITY = "fairing_density"
"""Float point attribute: smoothed density d of the last step, in the solver's [-3, 3]^3 frame."""

FIELD_ATTRIBUTES = {
    "DENSITY": DENSITY,
    "DISPLACEMENT": "fairing_displacement",
    "CURVATURE": "fairing_mean_curvature",
    "GAUSSIAN": "fairing_gaussian_curvature",
    "REMOVED": "fairing_removed",
}
"""Float attribute of each field that can be shown."""

COMPARED_FIELDS = ("DISPLACEMENT", "REMOVED")
"""Fields that compare the shown shape with the original."""

COLORS_BEFORE = "fairing_colors_before"
"""Custom property of a mesh: names of the active colours and of those of renders before a view."""


def color_name(name: str) -> str:
    """Name of the colour attribute that shows a float attribute."""
    return f"{name}_color"


def own_color(mesh: bpy.types.Mesh) -> str:
    """Name of the user's active colour attribute, also while a field is shown; empty for none."""
    name = mesh.get(COLORS_BEFORE, {}).get("active", mesh.attributes.active_color_name)
    return "" if is_of_field(name) else name


def is_of_field(name: str) -> bool:
    """Whether an attribute holds the numbers or the colours of a field."""
    return any(name in (each, color_name(each)) for each in FIELD_ATTRIBUTES.values())


def write_scalar(mesh: bpy.types.Mesh, name: str, values: ArrayLike) -> None:
    """Store one number per vertex; an earlier attribute of that name is replaced.

    Parameters
    ----------
    mesh
        Mesh in Object Mode.
    name
        Name of the attribute.
    values
        (n,) numbers, kept as float32.
    """
    values = _per_vertex(mesh, values)
    attribute = _point_attribute(mesh, name, "FLOAT")
    attribute.data.foreach_set("value", np.ascontiguousarray(values, dtype=np.float32))
    mesh.update()


def write_color(
    mesh: bpy.types.Mesh,
    name: str,
    values: ArrayLike,
    low: float | None = None,
    high: float | None = None,
    anchors: NDArray[np.float64] = ANCHORS,
) -> None:
    """Store one colour per vertex.

    If the mesh has no other colours, they become the active ones and those of renders.

    Parameters
    ----------
    mesh
        Mesh in Object Mode.
    name
        Name of the colour attribute; an earlier one of that name is replaced.
    values
        (n,) numbers, coloured by `color_map`; NaN is grey.
    low, high
        Values of the first and the last colour; None takes the range of the values.
    anchors
        Colours of the map, see `colors_srgb`.
    """
    values = _per_vertex(mesh, values)
    attribute = _point_attribute(mesh, name, "FLOAT_COLOR")  # the first one is made active
    colors = np.ones((len(values), 4), dtype=np.float32)
    colors[:, :3] = srgb_to_linear(colors_srgb(values, low, high, anchors))
    attribute.data.foreach_set("color", colors.ravel())
    mesh.update()


def write_density(mesh: bpy.types.Mesh, density: ArrayLike) -> None:
    """Store the density of a step under its two names, as numbers and as colours."""
    write_scalar(mesh, DENSITY, density)
    write_color(mesh, color_name(DENSITY), density, *color_range(density))


def remove_density(mesh: bpy.types.Mesh) -> None:
    """Remove what `write_density` has stored."""
    remove_attributes(mesh, (DENSITY, color_name(DENSITY)))


def _per_vertex(mesh: bpy.types.Mesh, values: ArrayLike) -> np.ndarray:
    values = np.asarray(values)
    if values.shape != (len(mesh.vertices),):
        raise ValueError(f"values of shape {values.shape}, the mesh needs ({len(mesh.vertices)},)")
    return values


def _point_attribute(mesh: bpy.types.Mesh, name: str, kind: str) -> bpy.types.Attribute:
    """Find or make the attribute; one of another type or domain is replaced."""
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.data_type, attribute.domain) != (kind, "POINT"):
        mesh.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = mesh.attributes.new(name, kind, "POINT")
    return attribute
