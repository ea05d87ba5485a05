"""Meshes, attributes, colours and shape keys of Blender, as numpy arrays and back."""
