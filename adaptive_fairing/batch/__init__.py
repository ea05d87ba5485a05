"""Many meshes: what there is to do, worker processes that do it, and the account of it.

No bpy here: it is the worker processes that have Blender in them.
"""
