"""Colours of a field on a mesh, their meaning in the record, and a material that renders them.

A field is numbers per vertex: a float attribute of the mesh, and a colour attribute beside it.
While a field is shown, its colours are the active ones of the mesh, in 3D views and in renders. The
colours that were active before are noted on the mesh, and become active again.

Every material slot of an object that is to be rendered so gets the material, in place of the
material of the mesh, which does not change. The earlier materials of the slots are noted in the
record, and come back.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np
from bpy.app.translations import pgettext_data as data_
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import ArrayLike

from .color_map import (
    ANCHORS,
    DIVERGING_ANCHORS,
    SIGNED_FIELDS,
    colors_srgb,
    field_range,
    srgb_to_linear,
)
from .display import display_of
from .mesh_arrays import AttributeArray, remove_attributes, write_attribute

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from ...core import FairingSettings

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

RENDERED_FIELD = "fairing_field"
"""Custom property that marks such a material: the field that it shows."""


def color_by_field(
    obj: bpy.types.Object, field: str, settings: FairingSettings | None = None
) -> None:
    """Store a field of the shape that an object shows, as numbers and as active colours.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    field
        Key of `FIELD_ATTRIBUTES`.
    settings
        As in `measure_field`, by default those of the core.

    Raises
    ------
    InputError
        The mesh is linked from another file; also as in `measure_field`.
    """
    from ...core import FairingSettings, InputError
    from .fields import measure_field

    mesh, record = obj.data, obj.adaptive_fairing
    if mesh.library is not None:
        raise InputError(rpt_("the mesh is linked from another file: make it local to color it"))
    found = measure_field(obj, field, settings or FairingSettings())
    if record.view != field:
        pause_view(obj)
    attributes = mesh.attributes
    if COLORS_BEFORE not in mesh:
        mesh[COLORS_BEFORE] = {
            "active": attributes.active_color_name,
            "rendered": attributes.default_color_name,
        }
    low, high = write_field(mesh, field, found.values)
    shown = color_name(FIELD_ATTRIBUTES[field])
    attributes.active_color_name = attributes.default_color_name = shown
    record.view, record.view_power = field, found.power
    record.view_range = low * found.unit, high * found.unit
    if record.wants_material:
        assign_material(obj, field)


def end_view(obj: bpy.types.Object) -> None:
    """Remove the colours of a view, and everything that they changed."""
    obj.adaptive_fairing.wants_material = False
    pause_view(obj)


def pause_view(obj: bpy.types.Object) -> str:
    """Remove the colours of a view and their numbers; a density that was asked for stays.

    Returns
    -------
    str
        The field that was shown, for `resume_view`; empty if none was.
    """
    mesh, record = obj.data, obj.adaptive_fairing
    view = record.view
    if not view:
        return view
    take_material_off(obj)
    name = FIELD_ATTRIBUTES[view]
    shown = color_name(name)
    before = mesh.pop(COLORS_BEFORE, None)
    chosen = [mesh.attributes.active_color_name, mesh.attributes.default_color_name]
    if view != "DENSITY" or not record.keeps_density:
        remove_attributes(mesh, (name, shown))
    if before is not None:
        # Whoever has chosen other colours in the meantime keeps them.
        if chosen[0] == shown and before["active"] in mesh.attributes:
            mesh.attributes.active_color_name = before["active"]
        if chosen[1] == shown and before["rendered"] in mesh.attributes:
            mesh.attributes.default_color_name = before["rendered"]
    record.view = ""
    return view


def resume_view(obj: bpy.types.Object, view: str, settings: FairingSettings | None = None) -> None:
    """Show a field again that `pause_view` has returned, as `color_by_field` does.

    If the shape before the runs is not known, there are no colours that compare with it.
    """
    if view and (view not in COMPARED_FIELDS or display_of(obj).has_original):
        color_by_field(obj, view, settings)


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


def write_field(mesh: bpy.types.Mesh, field: str, values: ArrayLike) -> tuple[float, float]:
    """Store a field as numbers and as colours, in place of earlier attributes of these names.

    If the mesh has no other colours, they become the active ones and those of renders.

    Parameters
    ----------
    mesh
        Mesh in Object Mode.
    field
        Key of `FIELD_ATTRIBUTES`.
    values
        (n,) numbers, kept as float32; NaN is grey.

    Returns
    -------
    float, float
        Values of the first and the last colour.
    """
    values, name = np.asarray(values), FIELD_ATTRIBUTES[field]
    if values.shape != (len(mesh.vertices),):
        raise ValueError(f"values of shape {values.shape}, the mesh needs ({len(mesh.vertices)},)")
    low, high = field_range(field, values)
    anchors = DIVERGING_ANCHORS if field in SIGNED_FIELDS else ANCHORS
    colors = np.ones((len(values), 4), dtype=np.float32)
    colors[:, :3] = srgb_to_linear(colors_srgb(values, low, high, anchors))
    write_attribute(mesh, AttributeArray(name, "FLOAT", "POINT", values))
    write_attribute(mesh, AttributeArray(color_name(name), "FLOAT_COLOR", "POINT", colors))
    mesh.update()
    return low, high


def remove_density(mesh: bpy.types.Mesh) -> None:
    """Remove a density that was asked for."""
    remove_attributes(mesh, (DENSITY, color_name(DENSITY)))


def assign_material(obj: bpy.types.Object, field: str) -> None:
    """Render an object in the colours of a field.

    Parameters
    ----------
    obj
        Mesh object in Object Mode, coloured by that field.
    field
        Key of `FIELD_ATTRIBUTES`.
    """
    take_material_off(obj)
    record, material = obj.adaptive_fairing, field_material(field)
    if not obj.material_slots:
        obj.data.materials.append(None)
        record.has_new_slot = True
    for slot in obj.material_slots:
        before = record.slots_before.add()
        before.link = slot.link
        slot.link = "OBJECT"
        before.material = slot.material
        slot.material = material


def take_material_off(obj: bpy.types.Object) -> None:
    """Give an object its materials back; a slot that has another material by now keeps it."""
    record = obj.adaptive_fairing
    for slot, before in zip(obj.material_slots, record.slots_before, strict=False):
        if slot.link == "OBJECT" and slot.material is not None and RENDERED_FIELD in slot.material:
            slot.material = before.material
            slot.link = before.link
    record.slots_before.clear()
    if record.has_new_slot and list(obj.data.materials) == [None]:
        if obj.material_slots[0].material is None:
            obj.data.materials.clear()
    record.has_new_slot = False
    for material in [each for each in bpy.data.materials if RENDERED_FIELD in each]:
        if material.users == 0 and material.library is None:
            bpy.data.materials.remove(material)


def field_material(field: str) -> bpy.types.Material:
    """Find or make the material of a field."""
    for material in bpy.data.materials:
        if material.get(RENDERED_FIELD) == field and material.library is None:
            return material
    material = bpy.data.materials.new(data_("Fairing Colors"))
    material[RENDERED_FIELD] = field
    if material.node_tree is None:  # since Blender 5.0 every material has one
        material.use_nodes = True
    nodes = material.node_tree.nodes
    shader = next(each for each in nodes if each.type == "BSDF_PRINCIPLED")
    shader.inputs["Roughness"].default_value = 0.8  # a shine would change the colours
    colors = nodes.new("ShaderNodeAttribute")
    colors.attribute_name = color_name(FIELD_ATTRIBUTES[field])
    colors.location = shader.location.x - 250, shader.location.y
    material.node_tree.links.new(colors.outputs["Color"], shader.inputs["Base Color"])
    return material
