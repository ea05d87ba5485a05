"""The Blender add-on: everything that is registered, in order.

Enabling it imports neither scipy nor the numeric core; they are imported when they are used.
"""

from __future__ import annotations

from types import ModuleType


def _modules() -> tuple[ModuleType, ...]:
    """Import the modules that register something; a class comes after those it refers to."""
    from . import command, preferences, properties
    from .data import record_properties
    from .operators import (
        animate,
        brush,
        check,
        compare,
        fair,
        fair_attribute,
        following,
        loop_subdivide,
        mesh_scale,
        modal_run,
        painting,
        results,
        select_problems,
        sequence,
        shortcuts,
        sliding,
        view,
        viewport,
    )
    from .ui import (
        attribute_panel,
        check_panel,
        colors_panel,
        finished_run_panels,
        manual,
        menus,
        noise_ring,
        presets,
        sequence_panel,
        settings_panel,
        split_line,
        translations,
    )

    return (
        translations,
        properties,
        preferences,
        record_properties,
        mesh_scale,
        viewport,
        following,
        modal_run,
        fair,
        brush,
        fair_attribute,
        painting,
        results,
        sliding,
        shortcuts,
        loop_subdivide,
        select_problems,
        view,
        animate,
        compare,
        check,
        sequence,
        presets,
        settings_panel,
        attribute_panel,
        check_panel,
        sequence_panel,
        colors_panel,
        finished_run_panels,
        split_line,
        noise_ring,
        menus,
        manual,
        command,
    )


def register() -> None:
    """Register everything with Blender."""
    for module in _modules():
        module.register()


def unregister() -> None:
    """Unregister everything that `register` has registered, in reverse order."""
    for module in reversed(_modules()):
        module.unregister()
