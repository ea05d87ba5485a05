"""Scripts with the extension in Blender without a window. Runs inside Blender.

Usage: blender -b --python-exit-code 9 --python background.py -- fair DIRECTORY
       blender -b --python-exit-code 9 --python background.py -- inspect FILE.blend DIRECTORY

``fair`` runs the operator on a noisy sphere, saves the sphere as ``noisy.obj`` and Blender's file
as ``script.blend``; ``inspect`` looks into a file. Both write ``result.json``.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import bpy
import numpy as np
from meshes import add_noisy, equal_to_core, key_positions, vertex_positions


def fair(directory: Path) -> dict:
    """Fair a sphere by the operator, which must block."""
    obj = add_noisy("ico_sphere", 0.01, subdivisions=5)
    bpy.ops.wm.obj_export(filepath=str(directory / "noisy.obj"), export_materials=False)
    noisy = vertex_positions(obj)
    status = bpy.ops.object.adaptive_fairing(algorithm="FAIR")
    keys = key_positions(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(directory / "script.blend"))
    return {
        "status": sorted(status),
        "keys": list(keys),
        "equal to core": equal_to_core(obj, noisy, list(keys.values())[1:]),
    }


def inspect(file: str) -> dict:
    """Tell what a saved file holds."""
    bpy.ops.wm.open_mainfile(filepath=file)
    (obj,) = (obj for obj in bpy.data.objects if obj.type == "MESH")
    keys = key_positions(obj)
    radii = {name: np.linalg.norm(positions, axis=1) for name, positions in keys.items()}
    return {
        "keys": list(keys),
        "absolute": not obj.data.shape_keys.use_relative,
        "animated": obj.data.shape_keys.animation_data is not None,
        "attributes": sorted(name for name in obj.data.attributes.keys() if "fairing" in name),
        "roughness": {name: float(radius.std()) for name, radius in radii.items()},
    }


if __name__ == "__main__":
    what, *arguments, directory = sys.argv[sys.argv.index("--") + 1 :]
    folder = Path(directory)
    result = fair(folder) if what == "fair" else inspect(*arguments)
    (folder / "result.json").write_text(json.dumps(result))
