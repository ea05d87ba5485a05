"""The Blender add-on: what there is to register, in order.

Enabling it imports neither scipy nor the numeric core; they are imported when they are used.
"""

from __future__ import annotations

from types import ModuleType


def _modules() -> tuple[ModuleType, ...]:
    """Import the modules that have something to register; what a class refers to comes first."""
    from . import (
        command,
        menus,
        mesh_scale,
        modal_run,
        operator_animate,
        operator_compare,
        operator_fair,
        operator_problems,
        operator_sequence,
        operator_tau,
        operator_view,
        panel_results,
        panel_sequence,
        panel_settings,
        pictures,
        presets,
        properties,
        record,
        translations,
        viewport,
    )

    return (
        translations,
        properties,
        record,
        pictures,
        mesh_scale,
        viewport,
        modal_run,
        operator_fair,
        operator_problems,
        operator_tau,
        operator_view,
        operator_animate,
        operator_compare,
        operator_sequence,
        presets,
        panel_settings,
        panel_sequence,
        panel_results,
        menus,
        command,
    )


def register() -> None:
    """Register everything with Blender."""
    for module in _modules():
        module.register()


def unregister() -> None:
    """Take back everything that `register` did, last things first."""
    for module in reversed(_modules()):
        module.unregister()
