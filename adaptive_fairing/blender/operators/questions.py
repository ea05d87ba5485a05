"""Warnings and confirmation before a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..choices import DENOISE
from ..data.display import leaves_keys
from ..data.mesh_arrays import is_shared
from ..data.modifier import NAME
from ..data.multires import shown_level
from ..data.shape_keys import animated_frames
from ..data.targets import needs_copy
from ..properties import way_of


def hints(objects: Sequence[bpy.types.Object], settings) -> list[str]:
    """Warnings on what a run will change beyond the meshes and on what it ignores, each once."""
    users = Counter(obj.data for obj in objects)
    found = (hint for obj in objects for hint in _hints_of(obj, settings, users[obj.data]))
    return list(dict.fromkeys(found))


def _hints_of(obj: bpy.types.Object, settings, n_users: int) -> list[str]:
    """Warnings on an object whose mesh so many objects of the run use."""
    mesh = obj.data
    found = []
    keeps_keys = leaves_keys(way_of(settings))
    if needs_copy(obj, in_place=keeps_keys):
        found.append("The result goes to a copy; this object is hidden")
    elif is_shared(mesh, among=n_users):
        found.append("Other objects share this mesh: they keep the old one")
    if settings.algorithm == DENOISE and not keeps_keys and animated_frames(obj) is not None:
        found.append("The animation of the evolution is removed with its shape keys")
    if obj.mode == "OBJECT" and shown_level(obj) is not None:
        found.append("Multiresolution: the level that is shown is denoised, without a slider")
    elif any(not each.name.startswith(NAME) and each.show_viewport for each in obj.modifiers):
        found.append("Modifiers stay above: the mesh below them is smoothed")
    low, high = min(obj.scale), max(obj.scale)
    if high - low > 0.01 * max(abs(low), abs(high)):
        found.append("The scale is not uniform: apply it first")
    if settings.from_original and obj.adaptive_fairing.result:
        found.append("From Original: what the runs have done since is discarded")
    return found


class Asking:
    """Mix-in of operators whose ``invoke`` asks first, if Blender cannot undo them.

    Scripts and Blender without a window are never asked: they do not call ``invoke``.
    """

    is_confirmed: bpy.props.BoolProperty(
        name="Confirmed",
        description="Do not ask, even if this cannot be undone",
        default=False,
        options={"HIDDEN", "SKIP_SAVE"},
    )

    def ask(self, context, button: str, lines: Iterable[str] = ()) -> set[str] | None:
        """Open a question and return the result for ``invoke``; None if there is nothing to ask.

        The answer starts the operator again.

        Parameters
        ----------
        context
        button
            Label of the answer.
        lines
            Further lines to show.
        """
        if self.is_confirmed or context.preferences.edit.use_global_undo:
            return None
        given = self.properties
        names = [each.identifier for each in given.bl_rna.properties if not each.is_readonly]

        def draw(menu, _context):
            column = menu.layout.column()
            for line in lines:
                column.label(text=iface_(line), icon="INFO", translate=False)
            column.operator_context = "INVOKE_DEFAULT"
            answer = column.operator(
                type(self).bl_idname, text=button, translate=False, icon="CHECKMARK"
            )
            for name in filter(given.is_property_set, names):
                setattr(answer, name, getattr(given, name))
            answer.is_confirmed = True

        title = iface_("Undo is turned off: this cannot be undone")
        context.window_manager.popup_menu(draw, title=title, icon="QUESTION")
        return {"CANCELLED"}
