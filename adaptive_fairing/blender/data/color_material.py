"""A material that renders the colours of a field, in place of the materials of an object.

Every material slot of the object gets it, in place of the material of the mesh, which does not
change. The earlier materials of the object's slots are noted in its record, and come back.
"""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_data as data_

from .field_attributes import FIELD_ATTRIBUTES, color_name

FIELD = "fairing_field"
"""Custom property that marks such a material: the field that it shows."""


def assign(obj: bpy.types.Object, field: str) -> None:
    """Render an object in the colours of a field.

    Parameters
    ----------
    obj
        Mesh object in Object Mode, coloured by that field.
    field
        Key of `FIELD_ATTRIBUTES`.
    """
    take_off(obj)
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


def take_off(obj: bpy.types.Object) -> None:
    """Give an object its materials back; a slot that has another material by now keeps it."""
    record = obj.adaptive_fairing
    for slot, before in zip(obj.material_slots, record.slots_before, strict=False):
        if slot.link == "OBJECT" and slot.material is not None and FIELD in slot.material:
            slot.material = before.material
            slot.link = before.link
    record.slots_before.clear()
    if record.has_new_slot and list(obj.data.materials) == [None]:
        if obj.material_slots[0].material is None:
            obj.data.materials.clear()
    record.has_new_slot = False
    for material in [each for each in bpy.data.materials if FIELD in each]:
        if material.users == 0 and material.library is None:
            bpy.data.materials.remove(material)


def field_material(field: str) -> bpy.types.Material:
    """Find or make the material of a field."""
    for material in bpy.data.materials:
        if material.get(FIELD) == field and material.library is None:
            return material
    material = bpy.data.materials.new(data_("Fairing Colors"))
    material[FIELD] = field
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
