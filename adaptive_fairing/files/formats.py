"""Formats of mesh files: Blender's operators for them, and their options.

Only data, no bpy: the command line checks names of files before it starts Blender.

The options serve one aim: the output holds what the input holds, and vertices that did not move
keep their coordinates. So nothing is merged, removed by validation or evaluated on the way, except
where the format itself demands it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

BLEND = ".blend"


@dataclass(frozen=True)
class MeshFormat:
    """Blender's operators and options for one kind of mesh file.

    Attributes
    ----------
    importer, exporter
        Names of operators in ``bpy.ops``. The options are their keyword arguments; those that a
        version of Blender does not know are left out.
    keeps_axes
        Whether coordinates can be read and written unchanged, without turning "Y up" to "Z up".
    holds_scene
        Whether the file can hold several objects; otherwise only the faired one is written.
    splits_vertices
        Whether a vertex is stored once for each of its normals and UVs, so that the surface comes
        back split at seams and sharp edges.
    dies_without_space
        Whether Blender crashes if the disk becomes full while it writes.
    """

    importer: str
    exporter: str
    import_options: Mapping[str, Any] = field(default_factory=dict)
    export_options: Mapping[str, Any] = field(default_factory=dict)
    keeps_axes: bool = False
    holds_scene: bool = True
    splits_vertices: bool = False
    dies_without_space: bool = False


OBJ = MeshFormat(
    importer="wm.obj_import",
    exporter="wm.obj_export",
    import_options={
        # Objects that share vertices stay one surface; the groups are kept as vertex groups.
        "use_split_objects": False,
        "import_vertex_groups": True,
        # Blender's validation turns coordinates that are not numbers into 0 without a word.
        "validate_meshes": False,
    },
    export_options={
        "apply_modifiers": False,
        "export_colors": True,
    },
    keeps_axes=True,
)

PLY = MeshFormat(
    importer="wm.ply_import",
    exporter="wm.ply_export",
    # UVs of the exporter cut the surface open at seams and renumber all vertices.
    export_options={"apply_modifiers": False, "export_uv": False},
    keeps_axes=True,
    holds_scene=False,
)

STL = MeshFormat(
    importer="wm.stl_import",
    exporter="wm.stl_export",
    import_options={"use_mesh_validate": False},
    export_options={"apply_modifiers": False},
    keeps_axes=True,
    holds_scene=False,
)

_GLTF_EXPORT: dict[str, Any] = {
    "export_apply": False,
    "export_attributes": True,
    "export_extras": True,
    "export_vertex_color": "ACTIVE",
    "export_all_vertex_colors": True,
}

GLB = MeshFormat(
    importer="import_scene.gltf",
    exporter="export_scene.gltf",
    export_options={**_GLTF_EXPORT, "export_format": "GLB"},
    splits_vertices=True,
)

GLTF = MeshFormat(
    importer="import_scene.gltf",
    exporter="export_scene.gltf",
    export_options={**_GLTF_EXPORT, "export_format": "GLTF_SEPARATE"},
    splits_vertices=True,
)

FBX = MeshFormat(
    importer="import_scene.fbx",
    exporter="export_scene.fbx",
    export_options={"use_mesh_modifiers": False, "use_custom_props": True},
)

USD = MeshFormat(
    importer="wm.usd_import",
    exporter="wm.usd_export",
    # Otherwise the active UV map would be called "st".
    export_options={"rename_uvmaps": False},
)

ALEMBIC = MeshFormat(
    importer="wm.alembic_import",
    exporter="wm.alembic_export",
    import_options={"as_background_job": False},
    export_options={"as_background_job": False},
    dies_without_space=True,
)

MESH_FORMATS: Mapping[str, MeshFormat] = {
    ".obj": OBJ,
    ".ply": PLY,
    ".stl": STL,
    ".glb": GLB,
    ".gltf": GLTF,
    ".fbx": FBX,
    ".usd": USD,
    ".usda": USD,
    ".usdc": USD,
    ".usdz": USD,
    ".abc": ALEMBIC,
}

SUFFIXES = (BLEND, *MESH_FORMATS)


def suffix_of(path: Path) -> str:
    """Suffix of a path in lower case; it decides the format."""
    return path.suffix.lower()


def is_supported(path: Path) -> bool:
    """Whether the suffix of a file is that of a known format."""
    return suffix_of(path) in SUFFIXES


def splits_vertices(path: Path) -> bool:
    """Whether a file of this format stores vertices split at seams and sharp edges."""
    file_format = MESH_FORMATS.get(suffix_of(path))
    return file_format is not None and file_format.splits_vertices


def keeps_axes(source: Path, destination: Path) -> bool:
    """Whether coordinates can go from one file to the other unchanged."""
    formats = [MESH_FORMATS.get(suffix_of(path)) for path in (source, destination)]
    return all(each is not None and each.keeps_axes for each in formats)
