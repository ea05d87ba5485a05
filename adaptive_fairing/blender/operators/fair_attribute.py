"""The operator that fairs attributes of the selected meshes: colours, weights, any numbers."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..choices import FAIR
from ..data.coloring import own_color
from ..data.object_mode import undoable_object_mode
from ..data.regions import refusal, target_objects, vertex_weights
from ..data.results import end_comparison, follow_weights
from ..data.vertex_groups import PAINT_GROUP
from ..properties import copy_settings, copy_solver, fairing_settings
from ..requirements import scipy_problem
from ..run_properties import OutputProperties, SolverProperties
from .polls import busy_refusal, is_allowed
from .settings_layout import draw_amount, draw_density, draw_region

SOURCES = (
    ("COLOR", "Active Color", "The active color attribute of every mesh"),
    ("GROUP", "Active Vertex Group", "The weights of the active vertex group of every object"),
    ("NAMED", "Attribute", "The attribute or vertex group of the given name"),
)

PAINTING = ("VERTEX_PAINT", "WEIGHT_PAINT")

REGION_NAMES = ("use_region", "vertex_group", "invert_vertex_group", "hold_sharp")


class OBJECT_OT_adaptive_fairing_attribute(SolverProperties, OutputProperties, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_attribute"
    bl_label = "Fair Attribute"
    bl_description = (
        "Smooth an attribute of the selected meshes, such as noisy colors, weights or measured "
        "values, with the scheme, the radius and the steps of Adaptive Fairing. The surface stays "
        "as it is"
    )
    bl_options = {"REGISTER", "UNDO"}

    source: bpy.props.EnumProperty(
        name="Source", description="What is smoothed", items=SOURCES, default="COLOR"
    )
    attribute: bpy.props.StringProperty(
        name="Attribute", description="Name of the attribute or vertex group to smooth"
    )

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, busy_refusal(), scipy_problem(), attribute_refusal(context))

    def draw(self, context):
        layout, obj = self.layout, context.active_object
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(self, "source")
        if self.source == "NAMED":
            layout.prop(self, "attribute")
        draw_amount(layout, self)
        draw_density(layout, self)
        draw_region(layout, self, obj)

    def execute(self, context):
        from ...core import FairingError

        try:
            settings = fairing_settings(self)
        except FairingError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        objects, mode = target_objects(context), context.active_object.mode
        n_done = 0
        with undoable_object_mode(context):
            for obj in objects:
                try:
                    self._fair(obj, mode, settings)
                    n_done += 1
                except FairingError as error:
                    level = "ERROR" if len(objects) == 1 else "WARNING"
                    self.report({level}, f"{obj.name}: {error}")
        return {"FINISHED"} if n_done else {"CANCELLED"}

    def _fair(self, obj, mode, settings):
        from ..jobs.fair_attribute import fair_attribute

        name = self._name(obj)
        weights = vertex_weights(
            obj,
            mode,
            len(obj.data.vertices),
            use_region=self.use_region,
            vertex_group=self.vertex_group,
            invert=self.invert_vertex_group,
            hold_sharp=self.hold_sharp,
        )
        end_comparison(obj)
        result = fair_attribute(obj, name, settings, weights=weights)
        if name == PAINT_GROUP:
            follow_weights(obj)
        text = rpt_("{:s}: {!r} is faired").format(obj.name, name)
        if result.n_limited:
            cut = rpt_(
                "{:d} values that overshot at a sharp step were clamped to between 0 and 1, as "
                "this type of value requires"
            )
            text += f"; {cut.format(result.n_limited)}"
        self.report({"INFO"}, text)

    def _name(self, obj):
        from ...core import InputError

        if self.source == "COLOR":
            name, missing = own_color(obj.data), rpt_("the mesh has no colors")
        elif self.source == "GROUP":
            group = obj.vertex_groups.active
            name, missing = group and group.name, rpt_("the object has no vertex group")
        else:
            name, missing = self.attribute, rpt_("name an attribute or a vertex group")
        if not name:
            raise InputError(missing)
        return name


def attribute_refusal(context: bpy.types.Context) -> str | None:
    """Reason why no attribute can be faired here; None if one can."""
    active = context.active_object
    if active is not None and active.mode in PAINTING:
        return None
    return refusal(context)


def draw_attribute_button(layout, settings, source, name="", **appearance):
    """Draw a button that fairs an attribute with the settings of the scene."""
    operator = layout.operator(OBJECT_OT_adaptive_fairing_attribute.bl_idname, **appearance)
    copy_solver(settings, operator, FAIR)
    copy_settings(settings, operator, REGION_NAMES)
    operator.source, operator.attribute = source, name
    return operator


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_attribute,))
