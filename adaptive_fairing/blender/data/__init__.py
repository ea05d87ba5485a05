"""Blender's meshes, attributes, colours and shape keys as numpy arrays, and back."""
