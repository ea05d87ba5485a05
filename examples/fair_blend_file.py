"""Fair every mesh of the .blend file that Blender has opened by the paper's method, step by step.

    blender -b scan.blend --python-exit-code 1 --python fair_blend_file.py -- faired.blend

The extension has to be installed; it is enabled here, for this run. Each mesh gets its four steps
as shape keys, and its density as a number and as a colour; the result is saved elsewhere.
"""

import sys

import bpy

bpy.ops.preferences.addon_enable(module="bl_ext.user_default.adaptive_fairing")
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=4)
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1])
