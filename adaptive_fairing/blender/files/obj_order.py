"""Faces of .obj files in the order of the mesh: Blender's exporter sorts them by material."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

_STATES = (b"s ", b"g ", b"usemtl ")
"""First words of lines that apply to all faces below them."""


def restore_order(path: Path) -> list[str]:
    """Rewrite an .obj file that was exported from the current scene, faces in order.

    An object whose faces in the file are not those of its mesh keeps the exporter's order.

    Returns
    -------
    list of str
        A sentence if faces without a group were put into one.
    """
    meshes = {
        # The exporter writes names without spaces.
        obj.name.replace(" ", "_"): obj.data
        for obj in bpy.context.scene.objects
        if obj.type == "MESH"
    }
    lines = path.read_bytes().splitlines(keepends=True)
    starts = [number for number, line in enumerate(lines) if line.startswith(b"o ")]
    written = lines[: starts[0]] if starts else lines
    n_vertices = 0
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        block = lines[start:end]
        mesh = meshes.get(block[0][2:].decode("utf-8", "surrogateescape").strip())
        written += block if mesh is None else _in_order(block, mesh, n_vertices)
        n_vertices += sum(line.startswith(b"v ") for line in block)
    path.write_bytes(b"".join(written))
    if b"g off\n" in written:
        return ["faces without a group are written as group 'off'"]
    return []


def _in_order(block: list[bytes], mesh: bpy.types.Mesh, n_before: int) -> list[bytes]:
    """Sort the lines of an object; the file has `n_before` vertices above it."""
    material = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("material_index", material)
    order = np.argsort(material, kind="stable")
    faces = [number for number, line in enumerate(block) if line.startswith(b"f ")]
    if (order[:-1] <= order[1:]).all() or not _are_faces_of(block, faces, mesh, order, n_before):
        return block
    states: list[dict[bytes, bytes]] = []
    current: dict[bytes, bytes] = {}
    for line in block[faces[0] - _n_states_above(block, faces[0]) :]:
        kind = next((each for each in _STATES if line.startswith(each)), None)
        if kind is not None:
            current = {**current, kind: line}
        elif line.startswith(b"f "):
            states.append(current)
    place = np.argsort(order)
    head = block[: faces[0] - _n_states_above(block, faces[0])]
    return [*head, *_with_states([(block[faces[at]], states[at]) for at in place])]


def _n_states_above(block: list[bytes], first: int) -> int:
    """Count the lines directly above the first face that set a state, such as a material."""
    count = 0
    while block[first - count - 1].startswith(_STATES):
        count += 1
    return count


def _with_states(faces: list[tuple[bytes, dict[bytes, bytes]]]) -> Iterator[bytes]:
    """Write faces, and above each face the states that have changed."""
    before: dict[bytes, bytes] = {}
    for face, state in faces:
        yield from (line for kind, line in state.items() if before.get(kind) != line)
        yield face
        before = state


def _are_faces_of(
    block: list[bytes],
    faces: list[int],
    mesh: bpy.types.Mesh,
    order: NDArray[np.intp],
    n_before: int,
) -> bool:
    """Whether the faces in the file are the polygons of the mesh in this order."""
    if len(faces) != len(order):
        return False
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    starts = np.empty(len(order) + 1, dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", starts[:-1])
    starts[-1] = len(corners)
    for number, polygon in zip(faces, order, strict=True):
        words = block[number].split()[1:]
        given = [int(word.partition(b"/")[0]) - 1 - n_before for word in words]
        if given != corners[starts[polygon] : starts[polygon + 1]].tolist():
            return False
    return True
