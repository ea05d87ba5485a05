"""Batches of meshes: plan, worker processes, records, summary.

No bpy here: it is the worker processes that have Blender in them.
"""
