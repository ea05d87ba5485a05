"""Files that Blender's importers misread, or die of."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object
from support.raw_files import write_raw

from adaptive_fairing.blender.data.mesh_arrays import read_triangles
from adaptive_fairing.blender.files.import_losses import import_notes
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh
from adaptive_fairing.core import FairingError
from adaptive_fairing.files.errors import FileError

CROSSED = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf 1 2 3\ng x\nf 2 4 3\n"


@pytest.mark.parametrize(
    "suffix", [".obj", ".ply", ".stl", ".fbx", ".usda", ".usdc", ".abc", ".glb", ".gltf"]
)
def test_no_format_turns_what_is_no_number_into_0(tmp_path, suffix):
    """By Blender's own exporters; those of glTF clean up, so there the number is put in."""
    vertices, faces = icosphere(1)
    vertices = vertices.astype(np.float32)
    mark = vertices[3, 0]
    if not suffix.startswith(".gl"):
        vertices[3, 0] = np.nan
    path = tmp_path / f"bad{suffix}"
    export_mesh(add_object(vertices, faces), path, alone=True)
    if suffix.startswith(".gl"):
        binary = path if suffix == ".glb" else path.with_suffix(".bin")
        data = binary.read_bytes()
        given = struct.pack("<f", mark)
        assert given in data
        binary.write_bytes(data.replace(given, struct.pack("<f", np.nan), 1))
    with pytest.raises(FairingError, match=r"\d+ vertices .*not finite numbers: \d+"):
        import_mesh(path)


def test_faces_before_the_first_group_do_not_kill_blender(tmp_path):
    path = tmp_path / "crossed.obj"
    path.write_text(CROSSED)
    obj = import_mesh(path)
    np.testing.assert_array_equal(read_triangles(obj.data), [[0, 1, 2], [1, 3, 2]])
    (note,) = import_notes(path)
    assert note.startswith("groups are left out")


def test_groups_that_blender_can_read_stay(tmp_path):
    path = tmp_path / "groups.obj"
    path.write_text(CROSSED.replace("f 1 2 3", "g y\nf 1 2 3"))
    assert [group.name for group in import_mesh(path).vertex_groups] == ["y", "x"]
    assert import_notes(path) == []


@pytest.mark.parametrize("count", ["4000000000", "many"])
def test_a_header_that_lies_does_not_kill_blender(tmp_path, count):
    with pytest.raises(FileError, match=r"given\.ply: "):
        import_mesh(write_raw(tmp_path, "ply as text", *icosphere(1), n_vertices=count))


@pytest.fixture(scope="module")
def repeated():
    """Give a mesh with repeated faces, and its faces without them: (vertices, faces, expected)."""
    vertices, faces = icosphere(6)
    rng = np.random.default_rng(1)
    again = rng.integers(0, len(faces), len(faces) // 8)
    order = rng.permutation(len(faces) + len(again))
    # The other way round, so that it shows which one was kept.
    given = np.vstack([faces, faces[again][:, ::-1]])[order]
    _, first = np.unique(np.sort(given, axis=1), axis=0, return_index=True)
    return vertices, given, given[np.sort(first)]


@pytest.mark.parametrize("kind", ["obj", "ply", "ply as text", "stl"])
def test_of_repeated_faces_the_first_is_kept_in_its_place(repeated, tmp_path, kind):
    """So many that Blender removes them in threads, in an order left to chance."""
    vertices, given, expected = repeated
    path = write_raw(tmp_path, kind, vertices, given)
    for _ in range(2):
        mesh = import_mesh(path, keep_axes=True).data
        found = read_triangles(mesh)
        if kind == "stl":  # Blender numbers the vertices as they come
            found = _in_order_of_use(given)[found]
        np.testing.assert_array_equal(_turned(found), _turned(expected))


def _in_order_of_use(faces):
    """Vertices in the order in which the faces name them first."""
    _, first = np.unique(faces, return_index=True)
    return faces.reshape(-1)[np.sort(first)]


def _turned(faces):
    """Begin every face with its lowest vertex."""
    first = np.argmin(faces, axis=1)
    return faces[np.arange(len(faces))[:, None], (first[:, None] + np.arange(3)) % 3]
