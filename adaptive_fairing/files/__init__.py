"""Files without Blender: formats, outputs that appear whole or not at all, JSON reports."""
