"""A stand-in for Blender's layouts, which exist while a window is drawn only.

It checks what the real one checks, and keeps what was drawn: texts, properties, operators.
"""

from types import SimpleNamespace

import bpy

from adaptive_fairing.blender.ui import (
    attribute_panel,
    check_panel,
    colors_panel,
    finished_run_panels,
    sequence_panel,
    settings_panel,
)

PANELS = [
    panel
    for module in (
        settings_panel,
        check_panel,
        attribute_panel,
        sequence_panel,
        colors_panel,
        finished_run_panels,
    )
    for name, panel in vars(module).items()
    if name.startswith("VIEW3D_PT_adaptive") and panel.__module__ == module.__name__
]
"""All panels of the add-on."""


class FakeLayout:
    """Takes the calls of a panel's draw function."""

    def __init__(self, drawn=None):
        self.drawn = (
            drawn
            if drawn is not None
            else SimpleNamespace(
                texts=[], marked=[], properties=[], disabled=[], operators=[], progress=[]
            )
        )
        self.enabled = True

    def _nested(self, *arguments, **options):
        return FakeLayout(self.drawn)

    row = column = box = split = grid_flow = _nested

    def separator(self, **options):
        pass

    def label(self, *, text="", icon="NONE", translate=True):
        known_icon(icon)
        self.drawn.texts.append(text)
        if icon == "CHECKMARK":
            self.drawn.marked.append(text)

    def progress(self, *, factor, text):
        assert 0.0 <= factor <= 1.0
        self.drawn.progress.append((factor, text))

    def prop(self, data, name, *, text=None, icon="NONE", slider=False, expand=False, toggle=False):
        known_icon(icon)
        if name.startswith("swatch"):
            return
        assert name in data.bl_rna.properties.keys() or hasattr(type(data), name), name
        self.drawn.properties.append(name)
        if not self.enabled:
            self.drawn.disabled.append(name)

    def prop_search(self, data, name, search_data, search_name):
        getattr(search_data, search_name)
        self.prop(data, name)

    def operator(self, name, *, text="", icon="NONE", depress=False, emboss=True, translate=True):
        known_icon(icon)
        category, _, function = name.partition(".")
        names = getattr(getattr(bpy.ops, category), function).get_rna_type().properties.keys()
        chosen = {"name": name, "text": text, "depress": depress}
        self.drawn.operators.append(chosen)
        return _OperatorProperties(set(names), chosen)

    def operator_menu_enum(self, name, property_name, *, text="", icon="NONE"):
        self.operator(name, text=text, icon=icon).__setattr__(property_name, None)

    def popover(self, *, panel, icon, text):
        getattr(bpy.types, panel)


class _OperatorProperties:
    """Takes settings for a button; only those that the operator has."""

    def __init__(self, names, chosen):
        object.__setattr__(self, "_names", names)
        object.__setattr__(self, "_chosen", chosen)

    def __setattr__(self, name, value):
        assert name in self._names, f"{self._chosen['name']} has no property {name}"
        self._chosen[name] = value


def known_icon(name):
    """Make sure that Blender has an icon."""
    icons = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items
    assert name in icons.keys(), name


class FakeContext:
    """Blender's context with what it lacks without a window: a region, a scale of the interface."""

    region = SimpleNamespace(width=300)
    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))

    def __getattr__(self, name):
        return getattr(bpy.context, name)


def draw(panel):
    """Draw a panel if it wants to be drawn.

    Returns
    -------
    SimpleNamespace or None
        What was drawn; None if the panel's poll said no.
    """
    context = FakeContext()
    if hasattr(panel, "poll") and not panel.poll(context):
        return None
    layout = FakeLayout()
    # The methods of the class, on an object that is no Blender panel.
    stand_in = type("Drawn", (), {**vars_of(panel), "layout": layout})()
    if hasattr(stand_in, "draw_header_preset"):
        stand_in.draw_header_preset(context)
    stand_in.draw(context)
    return layout.drawn


def vars_of(panel):
    """Collect the functions of a panel class and of its mix-ins."""
    found = {}
    for base in reversed(panel.__mro__):
        if base.__module__.startswith("adaptive_fairing"):
            found |= {k: v for k, v in vars(base).items() if not k.startswith("__")}
    return found
