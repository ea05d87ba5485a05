"""Binary .usd files, which only Blender can write here: what is read of them, and what refused."""

import random
import struct

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, add_rich_object, corners

from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh
from adaptive_fairing.files.errors import FileError
from adaptive_fairing.files.inspection import inspect
from adaptive_fairing.files.inspection.usd import _meshes


@pytest.mark.parametrize("suffix", [".usd", ".usda", ".usdc", ".usdz"])
@pytest.mark.parametrize("make", [lambda: add_object(*icosphere(5)), add_rich_object])
def test_faces_are_read_as_blender_has_them(tmp_path, suffix, make):
    obj = make()
    path = tmp_path / f"a{suffix}"
    export_mesh(obj, path, alone=True)
    (faces,) = _meshes(path.read_bytes())
    assert faces.counts.tolist() == [len(polygon.vertices) for polygon in obj.data.polygons]
    np.testing.assert_array_equal(faces.corners, corners(obj.data))
    assert faces.n_points == len(obj.data.vertices)


@pytest.fixture
def small(tmp_path):
    """Give a crate of four triangles, short enough for its numbers to be stored as they are."""
    tetrahedron = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    export_mesh(add_object(points, tetrahedron), tmp_path / "small.usdc", alone=True)
    return tmp_path / "small.usdc"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ((3, 3, 3, 3), (3, 3, 3, 30), "promise 39 corners of faces, 12 are there"),
        ((3, 3, 3, 3), (3, -3, 3, 3), "1 faces of .* have a negative number of corners"),
        ((1, 3, 2, 2), (1, 3, 99, 2), "1 faces name vertices that are not there: 2; "),
    ],
)
def test_faces_that_contradict_themselves_are_refused(small, old, new, message):
    data, old = small.read_bytes(), struct.pack("<4i", *old)
    assert data.count(old) == 1
    small.write_bytes(data.replace(old, struct.pack("<4i", *new)))
    with pytest.raises(FileError, match=message):
        import_mesh(small)


def test_packed_numbers_of_another_count_are_refused(tmp_path):
    path = tmp_path / "a.usdc"
    _, faces = icosphere(2)
    export_mesh(add_object(*icosphere(2)), path, alone=True)
    data, count = path.read_bytes(), struct.pack("<Q", faces.size)
    assert count in data
    path.write_bytes(data.replace(count, struct.pack("<Q", faces.size - 1)))
    with pytest.raises(FileError, match=f"promise {faces.size} corners .* {faces.size - 1} are"):
        import_mesh(path)


def test_a_damaged_crate_raises_nothing_but_file_errors(tmp_path):
    path, chance = tmp_path / "a.usdc", random.Random(0)
    export_mesh(add_object(*icosphere(2)), path, alone=True)
    sound, n_refused = path.read_bytes(), 0
    for _ in range(500):
        data = bytearray(sound)
        for _ in range(chance.choice([1, 5, 50])):
            data[chance.randrange(8, len(data))] = chance.choice([0, 1, 127, 128, 255])
        path.write_bytes(data[: chance.choice([len(data), chance.randrange(len(data))])])
        try:
            inspect(path)
        except FileError:
            n_refused += 1
    assert n_refused > 0
