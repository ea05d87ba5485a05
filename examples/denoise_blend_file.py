"""Denoise every mesh of the .blend file that Blender has opened, and save the result elsewhere.

    blender -b scan.blend --python-exit-code 1 --python denoise_blend_file.py -- denoised.blend

The extension has to be installed; it is enabled here, for this run. *Strength* in the tab
*Fairing* goes on working in the saved file. Clean meshes stay as they are.
"""

import sys

import bpy

bpy.ops.preferences.addon_enable(module="bl_ext.user_default.adaptive_fairing")
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.adaptive_fairing()
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1])
