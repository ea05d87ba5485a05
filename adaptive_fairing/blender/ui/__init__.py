"""Panels, menus, presets, links to the manual, translations."""
