"""Mesh files through Blender's importers and exporters, and what these lose."""
