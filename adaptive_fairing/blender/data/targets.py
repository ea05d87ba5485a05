"""Targets: the object that a run writes to, completely or not at all, without other harm."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy

from ...files.output_words import FAIRED
from .mesh_arrays import is_shared, write_positions
from .shape_keys import clear_animation, clear_keys, has_foreign_keys, shown_positions


def find_mesh_object(file_name: str, name: str | None = None) -> bpy.types.Object:
    """Find the mesh object of the loaded file.

    Parameters
    ----------
    file_name
        For error messages.
    name
        Name of the object; None if the file should hold a single mesh.

    Raises
    ------
    FairingError
        There is no such object, or there are several and no name was given.
    """
    from ...core import FairingError  # enabling the add-on does not load the core

    meshes = [obj for obj in bpy.data.objects if obj.type == "MESH" and obj.users_scene]
    names = ", ".join(repr(obj.name) for obj in meshes)
    if name is None:
        if not meshes:
            raise FairingError(f"{file_name} holds no mesh: give a file with a polygon mesh")
        if len(meshes) > 1:
            raise FairingError(
                f"{file_name} holds {len(meshes)} meshes: choose one with --object: {names}"
            )
        return meshes[0]
    for obj in meshes:
        if obj.name == name:
            return obj
    other = bpy.data.objects.get(name)
    if other is not None:
        kind = "not in any scene" if other.type == "MESH" else f"a {other.type.lower()}, not a mesh"
        raise FairingError(f"object {name!r} in {file_name} is {kind}; its meshes are: {names}")
    raise FairingError(f"{file_name} has no object {name!r}; its meshes are: {names or 'none'}")


def needs_copy(obj: bpy.types.Object, *, in_place: bool = False) -> bool:
    """Whether the object must not be changed, because it is linked or has shape keys of the user.

    `in_place` as in `writable_object`.
    """
    is_foreign = obj.library is not None or obj.override_library is not None
    return is_foreign or (has_foreign_keys(obj.data) and not in_place)


def writable_object(
    obj: bpy.types.Object, *, in_place: bool = False, word: str = FAIRED
) -> bpy.types.Object:
    """Object whose mesh nothing else uses and that may be changed.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    in_place
        Whether to write to an object with shape keys of the user, which stay, instead of a copy.
    word
        Word in the name of a copy, see `files.output_words`.

    Returns
    -------
    bpy.types.Object
        `obj` itself, its mesh made single-user if others share it or a library owns it. If it
        `needs_copy`, a new object "NAME WORD" in its place, with the shown shape and without keys;
        `obj` is hidden and otherwise unchanged.
    """
    if needs_copy(obj, in_place=in_place):
        return _copy_in_place(obj, word)
    mesh = obj.data
    if is_shared(mesh) or mesh.library is not None or mesh.override_library is not None:
        obj.data = mesh.copy()
    return obj


def _copy_in_place(obj: bpy.types.Object, word: str) -> bpy.types.Object:
    shown = shown_positions(obj.data)
    copy = obj.copy()
    copy.make_local(clear_liboverride=True)
    copy.name = f"{obj.name} {word}"
    copy.data = obj.data.copy()
    copy.data.make_local(clear_liboverride=True)
    if copy.data.shape_keys is not None:
        clear_keys(copy)
        write_positions(copy.data, shown)
    collections = [each for each in obj.users_collection if each.library is None]
    for collection in collections or [obj.users_scene[0].collection]:
        collection.objects.link(copy)
    for scene in obj.users_scene:
        for layer in scene.view_layers:
            if obj.name in layer.objects:
                obj.hide_set(True, view_layer=layer)
    if obj.library is None:
        obj.hide_render = True
    return copy


@contextmanager
def written_or_restored(
    obj: bpy.types.Object, *, in_place: bool = False, word: str = FAIRED
) -> Iterator[bpy.types.Object]:
    """Yield the object to write to, see `writable_object`; restore everything if the body fails.

    Blender itself restores nothing when an operator ends with an error.

    Parameters
    ----------
    obj
        Mesh object in Object Mode, without the colours of a field.
    in_place
        Whether to write to an object with shape keys of the user, which stay, instead of a copy.
    word
        As in `writable_object`.

    Yields
    ------
    bpy.types.Object
        `obj`, or a copy of it.
    """
    mesh = obj.data
    name, has_fake_user, active_key = mesh.name, mesh.use_fake_user, obj.active_shape_key_index
    visibility = _Visibility.of(obj)
    target = writable_object(obj, in_place=in_place, word=word)
    backup = mesh.copy() if target.data == mesh else None
    try:
        yield target
    except BaseException:
        broken = target.data
        if target == obj:
            obj.data = backup or mesh
        else:
            bpy.data.objects.remove(target)
            visibility.restore(obj)
        remove_mesh(broken)
        if backup is not None:
            backup.name, backup.use_fake_user = name, has_fake_user
            obj.active_shape_key_index = active_key
        raise
    if backup is not None:
        remove_mesh(backup)


@dataclass(frozen=True)
class _Visibility:
    """Visibility and selection of an object in each layer, and its visibility in renders."""

    in_layers: list[tuple[bpy.types.ViewLayer, bool, bool]]
    in_render: bool

    @classmethod
    def of(cls, obj: bpy.types.Object) -> _Visibility:
        layers = [layer for scene in obj.users_scene for layer in scene.view_layers]
        states = [
            (layer, obj.hide_get(view_layer=layer), obj.select_get(view_layer=layer))
            for layer in layers
            if obj.name in layer.objects
        ]
        return cls(states, obj.hide_render)

    def restore(self, obj: bpy.types.Object) -> None:
        for layer, is_hidden, is_selected in self.in_layers:
            obj.hide_set(is_hidden, view_layer=layer)
            obj.select_set(is_selected, view_layer=layer)
        if obj.library is None:
            obj.hide_render = self.in_render


def remove_mesh(mesh: bpy.types.Mesh) -> None:
    """Remove a mesh without users, and the animation of its keys if nothing else uses it."""
    if is_shared(mesh, among=0):  # Blender would remove its objects as well
        return
    if mesh.shape_keys is not None:
        clear_animation(mesh.shape_keys)
    bpy.data.meshes.remove(mesh)
