"""Panels, menus, presets, pictures, translations."""
