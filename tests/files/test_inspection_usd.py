"""Faces of .usd files: read as they are written, refused where they contradict each other."""

from __future__ import annotations

import random
import re
import struct
import zipfile

import pytest
from support.meshes import icosphere

from adaptive_fairing.files.errors import FileError
from adaptive_fairing.files.inspection import inspect
from adaptive_fairing.files.inspection.usd_crate import Crate, _unpacked

VERTICES, FACES = icosphere(1)


def usda(counts, corners, points=VERTICES, *, before=""):
    """Text of a file with one mesh."""
    rows = ", ".join("({:.9g}, {:.9g}, {:.9g})".format(*point) for point in points)
    return (
        f'#usda 1.0\n{before}\ndef Xform "Ball"\n{{\n    def Mesh "Skin"\n    {{\n'
        f"        int[] faceVertexCounts = {list(counts)}\n"
        f"        int[] faceVertexIndices = {list(corners)}\n"
        f"        point3f[] points = [{rows}]\n    }}\n}}\n"
    )


COUNTS, CORNERS = [3] * len(FACES), FACES.reshape(-1).tolist()
CONTRADICTIONS = [
    ([*COUNTS[:-1], 30], CORNERS, "'Skin' promise 267 corners of faces, 240 are there"),
    (COUNTS[:-3], CORNERS, "promise 231 corners of faces, 240 are there"),
    (COUNTS, CORNERS[:-20], "promise 240 corners of faces, 220 are there"),
    ([-3, *COUNTS[1:]], CORNERS, "1 faces of 'Skin' have a negative number of corners"),
    (COUNTS, [*CORNERS[:-1], 9999], "1 faces name vertices that are not there: 79; "),
    (COUNTS, [-7, *CORNERS[1:]], "1 faces name vertices that are not there: 0; "),
    ([*COUNTS[:-1], 2_000_000_000], CORNERS, "promise 2000000237 corners"),
]


@pytest.mark.parametrize("suffix", [".usda", ".usd", ".usdz"])
@pytest.mark.parametrize(("counts", "corners", "message"), CONTRADICTIONS)
def test_faces_that_contradict_themselves_are_refused(tmp_path, suffix, counts, corners, message):
    def write(name, text):
        path = tmp_path / name
        if suffix == ".usdz":
            with zipfile.ZipFile(path, "w") as package:
                package.writestr("mesh.usda", text)
        else:
            path.write_text(text)
        return path

    inspect(write(f"good{suffix}", usda(COUNTS, CORNERS)))
    with pytest.raises(FileError, match=message):
        inspect(write(f"bad{suffix}", usda(counts, corners)))


def test_each_mesh_has_its_own_numbers(tmp_path):
    other = 'def Mesh "First"\n{\n    int[] faceVertexCounts = [3]\n}\n'
    (tmp_path / "two.usda").write_text(usda(COUNTS, CORNERS, before=other))
    inspect(tmp_path / "two.usda")


def test_text_where_numbers_should_be_is_refused(tmp_path):
    (tmp_path / "bad.usda").write_text(re.sub(r"\[3, ", "[three, ", usda(COUNTS, CORNERS), count=1))
    with pytest.raises(FileError, match="text where a whole number should be"):
        inspect(tmp_path / "bad.usda")


@pytest.mark.parametrize("seed", range(20))
def test_what_was_packed_comes_out(seed):
    """By a packer that knows texts and repetitions, those that overlap among them."""
    chance = random.Random(seed)
    text, packed = bytearray(), bytearray()
    for _ in range(30):
        new = chance.randbytes(chance.choice([1, 3, 14, 15, 16, 270, 600]))
        text += new
        again, back = chance.choice([4, 18, 19, 20, 300, 1000]), chance.randint(1, len(text))
        mark = min(len(new), 15) << 4 | min(again - 4, 15)
        packed += bytes([mark]) + _rest(len(new)) + new + struct.pack("<H", back) + _rest(again - 4)
        for _ in range(again):
            text.append(text[-back])
    text += b"end"
    packed += bytes([3 << 4]) + b"end"
    assert _unpacked(bytes(packed)) == bytes(text)


def _rest(length):
    """Write what a length has beyond 15."""
    if length < 15:
        return b""
    return b"\xff" * ((length - 15) // 255) + bytes([(length - 15) % 255])


def test_a_crate_of_another_version_is_not_read():
    with pytest.raises(NotImplementedError):
        Crate(b"PXR-USDC" + bytes([0, 1]) + bytes(100))
