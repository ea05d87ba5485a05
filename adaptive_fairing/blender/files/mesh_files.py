"""Mesh files through Blender's importers and exporters; outputs appear whole or not."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy

from ...files.atomic_files import replaced_file, replaced_files, require_space
from ...files.companions import names_to_change, rename_in_gltf, rename_in_obj
from ...files.errors import FileError
from ...files.formats import BLEND, GLTF, MESH_FORMATS, OBJ, PLY, STL, MeshFormat, suffix_of
from ...files.inspection import inspect
from ...files.inspection.contents import Contents, is_far
from ...silence import silent_output
from ..compatibility import known_options, show_scene
from ..data.targets import find_mesh_object
from .far_meshes import move_near_origin, rounding_notes, world_points
from .obj_order import restore_order
from .obj_precision import restore_precision
from .ply_export import prepare_for_ply
from .ply_precision import write_doubles
from .texture_names import write_with_other_textures
from .validation import validate

_AXES_AS_IN_FILE = {"forward_axis": "Y", "up_axis": "Z"}


def import_mesh(
    path: Path, object_name: str | None = None, *, keep_axes: bool = False
) -> bpy.types.Object:
    """Load a file in place of everything that Blender holds, and find the mesh to smooth.

    Parameters
    ----------
    path
        A .blend file, or any format of `MESH_FORMATS`, which is loaded into an empty scene.
    object_name
        Name of the mesh object; needed only if the file holds several.
    keep_axes
        Whether to read coordinates unchanged, in formats that do not define their axes.

    Raises
    ------
    FileError
        The file cannot be read, or the mesh has no faces.
    FairingError
        There is no mesh, there are several and no name was given, or none has that name.
    InputError
        Coordinates are not finite, or faces name vertices that do not exist.
    """
    path = Path(os.path.abspath(path))
    _require_readable(path)
    if suffix_of(path) == BLEND:
        _call(path, "wm.open_mainfile", {"filepath": str(path), "use_scripts": False})
    else:
        _import_into_empty_scene(path, split=object_name is not None, keep_axes=keep_axes)
    obj = find_mesh_object(path.name, object_name)
    if len(obj.data.polygons) == 0:
        raise FileError(f"{obj.name!r} in {path.name} has no faces: there is no surface to fair")
    if obj.mode != "OBJECT":
        # The mesh of an object in Edit Mode or Sculpt Mode is not up to date.
        with bpy.context.temp_override(object=obj, active_object=obj):
            bpy.ops.object.mode_set(mode="OBJECT")
    return obj


def export_mesh(
    obj: bpy.types.Object, path: Path, *, alone: bool, keep_axes: bool = False
) -> list[str]:
    """Write a mesh file; modifiers and shape keys are not applied where the format allows it.

    Parameters
    ----------
    obj
        The object; for .ply its colours and attributes are changed to suit the exporter.
    path
        Output; its suffix chooses the format.
    alone
        Whether to write this object only, instead of the whole scene.
    keep_axes
        As in `import_mesh`.

    Returns
    -------
    list of str
        Losses in this format, one sentence each.

    Raises
    ------
    FileError
        Blender cannot write the file.
    OSError
        The path cannot be written to.
    """
    file_format = MESH_FORMATS[suffix_of(path)]
    options = _export_options(obj, file_format, keep_axes=keep_axes)
    notes = prepare_for_ply(obj.data) if file_format is PLY else []
    if alone or not file_format.holds_scene:
        _show_alone(obj)
    with replaced_files(path) as draft:
        if file_format.dies_without_space:
            require_space(draft.parent, _size_bound())

        def write() -> None:
            _write(path, file_format.exporter, {**options, "filepath": str(draft)}, draft)
            if not draft.is_file():
                raise FileError(f"cannot write {path}: Blender wrote nothing")

        write()
        names = names_to_change(draft)
        if file_format is OBJ:
            rename_in_obj(draft, names)
        elif file_format is GLTF:
            rename_in_gltf(draft, names)
        elif names:
            write_with_other_textures(draft, names, write)
        notes += [
            f"{old} is taken by another file: the output has {new} instead"
            for old, new in names.items()
        ]
        notes += _restore(draft, obj, file_format, keep_axes=keep_axes)
    return notes


def _export_options(
    obj: bpy.types.Object, file_format: MeshFormat, *, keep_axes: bool
) -> dict[str, Any]:
    options = dict(file_format.export_options)
    if file_format.keeps_axes and keep_axes:
        options |= _AXES_AS_IN_FILE
    if file_format in (OBJ, PLY):
        # Without normals of its own a mesh stays one whose readers compute them.
        options["export_normals"] = obj.data.has_custom_normals
    if file_format is OBJ:
        # Otherwise all faces of a mesh without groups would get the group "off".
        options["export_vertex_groups"] = any(
            each.vertex_groups for each in bpy.context.scene.objects
        )
        # Without materials the .mtl file would say nothing.
        options["export_materials"] = bool(bpy.data.materials)
    return options


def _restore(
    draft: Path, obj: bpy.types.Object, file_format: MeshFormat, *, keep_axes: bool
) -> list[str]:
    """Restore what the exporter lost (digits, order), and note what cannot be restored."""
    if file_format is OBJ:
        restore_precision(draft, keep_axes=keep_axes)
        return restore_order(draft)
    if file_format is PLY and is_far(world_points(obj)):
        write_doubles(draft, world_points(obj))
    if file_format is STL:
        return rounding_notes(world_points(obj), "coordinates are")
    return _split_vertices(draft) if file_format.splits_vertices else []


def _split_vertices(path: Path) -> list[str]:
    """Note how many vertices were split in a file that was exported from the scene."""
    meshes = [obj.data for obj in bpy.context.scene.objects if obj.type == "MESH"]
    n_vertices, n_points = sum(len(mesh.vertices) for mesh in meshes), inspect(path).n_points
    if n_points is None or n_points <= n_vertices:
        return []
    return [
        f"{n_vertices} vertices are stored as {n_points}: the format has one for each normal, UV "
        "and colour at a vertex"
    ]


def save_blend(path: Path) -> None:
    """Save everything that Blender holds as a .blend file.

    Raises
    ------
    FileError, OSError
        As in `export_mesh`.
    """
    with replaced_file(path) as draft:
        options = {"filepath": str(draft), "copy": True, "check_existing": False}
        _write(path, "wm.save_as_mainfile", options, draft)


def empty_scene() -> None:
    """Load Blender's factory start-up scene without its objects; add-ons stay enabled."""
    with silent_output():
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def _require_readable(path: Path) -> None:
    try:
        path.open("rb").close()
    except FileNotFoundError as error:
        raise FileError(f"cannot read {path}: there is no such file") from error
    except OSError as error:
        raise FileError(f"cannot read {path}: {error.strerror}") from error


def _import_into_empty_scene(path: Path, *, split: bool, keep_axes: bool) -> None:
    contents = inspect(path)
    file_format = MESH_FORMATS[suffix_of(path)]
    options = dict(file_format.import_options)
    if split and "use_split_objects" in options:
        # An object was named, so the objects of the file must not become one.
        options["use_split_objects"] = True
    if contents.has_faces_before_groups:
        # Blender 5.0 crashes on faces before the first group.
        options["import_vertex_groups"] = False
    if file_format.keeps_axes and keep_axes:
        options |= _AXES_AS_IN_FILE
    empty_scene()
    with _readable(path, contents) as file:
        _call(path, file_format.importer, {**options, "filepath": str(file)})
    for mesh in bpy.data.meshes:
        validate(mesh)
    if contents.far is not None:
        move_near_origin(contents.far)


@contextmanager
def _readable(path: Path, contents: Contents) -> Iterator[Path]:
    """Path that the importer reads correctly: the file itself, or a corrected copy."""
    if contents.readable is None:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        # Blender names the mesh after the file.
        copy = Path(folder) / path.name
        copy.write_bytes(contents.readable)
        yield copy


def _size_bound() -> int:
    """Most bytes that the meshes of the scene take in a file, if no modifier enlarges them."""
    elements = sum(
        len(obj.data.vertices) + len(obj.data.loops)
        for obj in bpy.context.scene.objects
        if obj.type == "MESH"
    )
    # Position, index, normal and UV of an element are 36 bytes; the rest is for their frame.
    return 64 * elements + (1 << 16)


def _show_alone(obj: bpy.types.Object) -> None:
    """Replace all scenes by one with only this object, visible."""
    scene = bpy.data.scenes.new(obj.name)
    scene.collection.objects.link(obj)
    if obj.library is None:
        obj.hide_viewport = False
    show_scene(scene)
    # Some exporters write every scene of the file.
    bpy.data.batch_remove([each for each in bpy.data.scenes if each != scene])


def _write(path: Path, name: str, options: Mapping[str, Any], draft: Path) -> None:
    """Run an operator that writes a file; report a full disk in one way, where Blender has many."""
    try:
        _call(path, name, options)
    except FileError:
        require_space(draft.parent, _size_bound())
        raise


def _call(path: Path, name: str, options: Mapping[str, Any]) -> None:
    """Run an operator on a file; an error of it becomes one line."""
    operator = _operator(name)
    verb = "write" if "export" in name or "save" in name else "read"
    try:
        with silent_output():
            outcome = operator(**known_options(operator, dict(options)))
    except RuntimeError as error:
        raise FileError(f"cannot {verb} {path}: {_reason(str(error))}") from error
    if outcome != {"FINISHED"}:
        raise FileError(f"cannot {verb} {path}: Blender gave up without a reason")


def _reason(text: str) -> str:
    """Reason in the message of an operator; for a traceback, its last line."""
    lines = [line.strip() for line in text.removeprefix("Error: ").splitlines() if line.strip()]
    if any("Traceback (most recent call last)" in line for line in lines):
        lines = [line for line in lines if not line.startswith("Location:")][-1:]
    return " ".join(lines)


def _operator(name: str) -> Callable[..., set[str]]:
    group, _, function = name.partition(".")
    return getattr(getattr(bpy.ops, group), function)
