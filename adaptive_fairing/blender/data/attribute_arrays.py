"""Attributes of any type and domain as arrays, and back onto another mesh."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

STORAGE = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int8),
    "BOOLEAN": ("value", 1, np.bool_),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
    "FLOAT4X4": ("value", 16, np.float32),
    "INT16_2D": ("value", 2, np.int16),
    "INT32_2D": ("value", 2, np.int32),
}
"""Property, numbers per element and their type, by Blender's type; texts are treated separately."""

TEXT = "STRING"

GEOMETRY = ("position", ".edge_verts", ".corner_vert", ".corner_edge")
"""Attributes that are the mesh itself."""


class AttributeArray(NamedTuple):
    """An attribute: numbers (n,) or (n, width), or texts (n,)."""

    name: str
    data_type: str
    domain: str
    values: NDArray


def read_attributes(mesh: bpy.types.Mesh, without: tuple[str, ...] = ()) -> list[AttributeArray]:
    """Read every attribute of a mesh in Object Mode, except its geometry and the given names."""
    arrays = []
    for attribute in mesh.attributes:
        if attribute.name in GEOMETRY or attribute.name in without:
            continue
        if attribute.data_type == TEXT:
            values = np.array([item.value for item in attribute.data], dtype=object)
        elif attribute.data_type in STORAGE:
            values = read_values(attribute)
        else:
            continue
        described = attribute.name, attribute.data_type, attribute.domain
        arrays.append(AttributeArray(*described, values))
    return arrays


def read_values(attribute: bpy.types.Attribute) -> NDArray:
    """Read an attribute of a type in `STORAGE`: (n,) or (n, width)."""
    name, width, dtype = STORAGE[attribute.data_type]
    values = np.empty(width * len(attribute.data), dtype=dtype)
    attribute.data.foreach_get(name, values)
    return values if width == 1 else values.reshape(-1, width)


def write_attribute(mesh: bpy.types.Mesh, array: AttributeArray) -> None:
    """Write an attribute to a mesh in Object Mode; it replaces one of the same name."""
    present = mesh.attributes.get(array.name)
    if present is not None and (present.data_type, present.domain) != array[1:3]:
        mesh.attributes.remove(present)
        present = None
    attribute = present or mesh.attributes.new(array.name, array.data_type, array.domain)
    if array.data_type == TEXT:
        for item, value in zip(attribute.data, array.values, strict=True):
            item.value = value
        return
    name, _, dtype = STORAGE[array.data_type]
    attribute.data.foreach_set(name, np.ascontiguousarray(array.values, dtype=dtype).reshape(-1))


def remove_attributes(mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Remove attributes by their names; a missing one is not an error."""
    attributes = mesh.attributes
    for name in names:
        if name in attributes:
            attributes.remove(attributes[name])
            # Since Blender 5.2 colours stay the active ones after they are gone.
            for which in ("active_color_name", "default_color_name"):
                if getattr(attributes, which) == name:
                    setattr(attributes, which, next(iter(mesh.color_attributes.keys()), ""))


def read_or_zeros(mesh: bpy.types.Mesh, name: str, size: int, dtype: type = np.float32) -> NDArray:
    """Read a number or a flag, (size,); zeros where the mesh has no such attribute."""
    attribute = mesh.attributes.get(name)
    return np.zeros(size, dtype) if attribute is None else read_values(attribute)
