"""Rollback: an object is written completely or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy

from ...files.output_words import FAIRED
from .mesh_arrays import is_shared
from .shape_keys import clear_animation
from .targets import writable_object


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
