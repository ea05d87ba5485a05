"""Batches of meshes: plan, worker processes, records, summary.

No bpy here: Blender runs in the worker processes.
"""
