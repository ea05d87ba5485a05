"""Files that contradict themselves are refused with numbers, before Blender sees them."""

from __future__ import annotations

import re
import struct

import numpy as np
import pytest
from support.meshes import icosphere
from support.raw_files import WRITERS, glb_bytes, ply_bytes, write_raw

from adaptive_fairing.files.errors import FileError
from adaptive_fairing.files.inspection import inspect
from adaptive_fairing.files.inspection.contents import Contents, repeated

VERTICES, FACES = icosphere(1)
COUNTED = ("obj", "ply", "big-endian ply", "ply as text")
INDEXED = (*COUNTED, "glb")
OF_NO_NUMBERS = {"nan": np.nan, "inf": np.inf, "-inf": -np.inf}


@pytest.mark.parametrize("kind", WRITERS)
def test_a_good_file_is_counted(tmp_path, kind):
    found = inspect(write_raw(tmp_path, kind, VERTICES, FACES))
    assert isinstance(found, Contents)
    if kind in COUNTED:
        assert (found.n_vertices, found.n_faces) == (len(VERTICES), len(FACES))
    assert found.readable is None and found.far is None


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("value", OF_NO_NUMBERS.values(), ids=OF_NO_NUMBERS)
def test_coordinates_that_are_not_finite_are_counted_and_named(tmp_path, kind, value):
    vertices = VERTICES.copy()
    vertices[[3, 17], [0, 2]] = value
    bad = [3, 17]
    if kind.startswith("stl"):  # each triangle has corners of its own
        bad = list(np.flatnonzero(np.isin(FACES.reshape(-1), [3, 17])))
    with pytest.raises(FileError, match="not finite numbers") as caught:
        inspect(write_raw(tmp_path, kind, vertices, FACES))
    assert f"{len(bad)} vertices" in str(caught.value)
    assert f"finite numbers: {', '.join(map(str, bad[:5]))}" in str(caught.value)


@pytest.mark.parametrize("text", ["1e400", "-1e39", "340282356779733661637539395458142568448"])
def test_numbers_beyond_single_precision_are_not_finite(tmp_path, text):
    path = tmp_path / "far.obj"
    path.write_text(f"v 0 0 0\nv {text} 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(FileError, match=r"1 vertices have coordinates .* numbers: 1;"):
        inspect(path)


def test_a_large_number_that_is_finite_is_taken(tmp_path):
    path = tmp_path / "far.obj"
    path.write_text("v 0 0 0\nv 3.4028234e38 -1e-45 +.5\nv 0\t1. 0 # right\r\nf 1 2 3\n")
    assert inspect(path) == Contents(3, 1)


@pytest.mark.parametrize("line", ["v 1,0 0 0", "v 1 2", "v one 0 0", "v 1_0 0 0"])
def test_vertices_that_are_not_three_numbers_are_named(tmp_path, line):
    path = tmp_path / "text.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\n{line}\nf 1 2 3\n")
    with pytest.raises(FileError, match="1 vertices are not three numbers: 2"):
        inspect(path)


@pytest.mark.parametrize("kind", INDEXED)
def test_faces_whose_vertices_do_not_exist_are_named(tmp_path, kind):
    faces = FACES.copy()
    faces[[7, 9], [0, 2]] = len(VERTICES), len(VERTICES) + 1000
    with pytest.raises(FileError, match="name vertices that are not there: ") as caught:
        inspect(write_raw(tmp_path, kind, VERTICES, faces))
    named = "21, 29" if kind == "glb" else "7, 9"
    assert f"not there: {named}; " in str(caught.value)
    assert f" has {len(VERTICES)} vertices" in str(caught.value)


@pytest.mark.parametrize(
    ("face", "is_good"),
    [
        ("f 1/1/1 2//1 3/1", True), ("f -1 -2 -3", True), ("f 1 2 \\\n3", True),
        ("f 0 1 2", False), ("f -4 -1 -2", False), ("f 1 2 4\nv 1 1 1", False),
        ("f 1 2 three", False), ("f 1 2 99999999999999999999", False), ("f 1.5 2 3", False),
    ],
)  # fmt: skip
def test_the_ways_to_name_a_vertex(tmp_path, face, is_good):
    path = tmp_path / "named.obj"
    path.write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}\n")
    if is_good:
        assert inspect(path).n_faces == 1
    else:
        with pytest.raises(FileError):
            inspect(path)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.1, 0.5, 0.9])
@pytest.mark.parametrize("kind", [kind for kind in WRITERS if kind != "obj"])
def test_a_file_that_is_cut_short_is_refused(tmp_path, kind, share):
    path = write_raw(tmp_path, kind, VERTICES, FACES)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(FileError, match=r"cannot read .*given\.\w+: .*"):
        inspect(path)


@pytest.mark.parametrize("kind", ["ply", "big-endian ply", "ply as text"])
def test_a_ply_that_is_cut_short_says_what_is_there(tmp_path, kind):
    path = write_raw(tmp_path, kind, VERTICES, FACES, n_faces=len(FACES) + 5)
    with pytest.raises(FileError, match=f"promises 85 rows of 'face', {len(FACES)} of them"):
        inspect(path)


@pytest.mark.parametrize("count", ["4000000000", "many", "-1", "1e3", "99999999999999999999"])
@pytest.mark.parametrize("kind", ["ply", "ply as text"])
def test_a_ply_header_that_lies_is_refused(tmp_path, kind, count):
    with pytest.raises(FileError, match=r"cut short|makes no sense"):
        inspect(write_raw(tmp_path, kind, VERTICES, FACES, n_vertices=count))


@pytest.mark.parametrize("n_vertices", [len(VERTICES) + 1, 4_000_000_000, -1, 1.5, "many"])
def test_a_glb_accessor_that_lies_is_refused(tmp_path, n_vertices):
    with pytest.raises(FileError, match=r"cut short|structure is damaged"):
        inspect(write_raw(tmp_path, "glb", VERTICES, FACES, n_vertices=n_vertices))


def test_a_stl_header_that_lies_is_refused(tmp_path):
    path = write_raw(tmp_path, "stl", VERTICES, FACES, n_faces=4_000_000_000)
    with pytest.raises(FileError, match="promises 4000000000 triangles, but 80 fit into it"):
        inspect(path)


@pytest.mark.parametrize("kind", ["ply", "big-endian ply", "ply as text"])
def test_faces_of_several_sizes_are_read(tmp_path, kind):
    faces = [list(FACES[0]), [0, 1, 2, 3], list(FACES[1]), [5, 6, 7, 8, 9]]
    assert inspect(write_raw(tmp_path, kind, VERTICES, faces)).n_faces == 4
    with pytest.raises(FileError, match="1 faces name vertices that are not there: 3"):
        inspect(write_raw(tmp_path, kind, VERTICES, [*faces[:3], [5, 6, 7, 8, 4000]]))


@pytest.mark.parametrize("form", ["binary_little_endian", "binary_big_endian", "ascii"])
def test_repeated_faces_are_found_and_cut_out(tmp_path, form):
    kind = {"binary_little_endian": "ply", "ascii": "ply as text"}.get(form, "big-endian ply")
    faces = [[0, 1, 2], [3, 4, 5], [2, 1, 0], [0, 1, 2, 3], [1, 2, 0], [3, 2, 1, 0], [6, 7, 8]]
    path = write_raw(tmp_path, kind, VERTICES, faces)
    given = inspect(path).readable
    kept = write_raw(tmp_path, kind, VERTICES, [faces[i] for i in (0, 1, 3, 6)])
    assert given == kept.read_bytes()


def test_repeated_faces_of_no_faces():
    assert len(repeated([], [0])) == 0


@pytest.mark.parametrize("kind", ["ply", "big-endian ply", "ply as text"])
def test_a_header_with_odd_comments_is_read(tmp_path, kind):
    """In UTF-8 "Å" ends with a byte that Latin-1 takes for the end of a line."""
    path = write_raw(tmp_path, kind, VERTICES, FACES)
    comment = "comment Ångström\ncomment end_header is below\nobj_info end_header".encode()
    path.write_bytes(path.read_bytes().replace(b"comment made by a test", comment))
    assert inspect(path) == Contents(len(VERTICES), len(FACES))


@pytest.mark.parametrize("kind", ["ply", "big-endian ply", "ply as text"])
def test_points_without_faces_are_counted(tmp_path, kind):
    assert inspect(write_raw(tmp_path, kind, VERTICES, [])) == Contents(len(VERTICES), 0)


@pytest.mark.parametrize("kind", ["ply", "ply as text"])
def test_rows_without_properties_are_refused(tmp_path, kind):
    path = write_raw(tmp_path, kind, VERTICES, FACES)
    rows = b"element foo 1000000000\nend_header"
    path.write_bytes(path.read_bytes().replace(b"end_header", rows))
    with pytest.raises(FileError, match="promises 1000000000 rows of 'foo' without properties"):
        inspect(path)


def test_a_count_of_thousands_of_digits_is_refused(tmp_path):
    with pytest.raises(FileError, match="makes no sense"):
        inspect(write_raw(tmp_path, "ply", VERTICES, FACES, n_vertices="9" * 5000))


@pytest.mark.parametrize(("good", "bad"), [("3 40 19", "3 4e1 19"), ("3 40 19", "3. 40 19")])
def test_a_ply_whose_whole_numbers_are_none_is_refused(tmp_path, good, bad):
    path = write_raw(tmp_path, "ply as text", VERTICES, FACES)
    text = path.read_text()
    assert f"\n{good} " in text
    path.write_text(text.replace(f"\n{good} ", f"\n{bad} "))
    with pytest.raises(FileError, match=r"'(4e1|3\.)' where a whole number should be"):
        inspect(path)


@pytest.mark.parametrize("kind", ["double ply", "obj", "stl as text"])
@pytest.mark.parametrize("size", [1e-300, 1e-40])
def test_a_mesh_too_small_for_single_precision_is_refused(tmp_path, kind, size):
    if kind == "double ply":
        path = tmp_path / "tiny.ply"
        path.write_bytes(ply_bytes(size * VERTICES, FACES, number="double"))
    else:
        path = write_raw(tmp_path, kind.removeprefix("double "), np.eye(3), [[0, 1, 2]])
        path.write_text(re.sub(r"\b1\b(?= |\n)(?=[^f]*f)", str(size), path.read_text()))
    with pytest.raises(FileError, match=f"largest coordinate is {size:.3g}, too small"):
        inspect(path)


@pytest.mark.parametrize("change", [str.upper, lambda text: f"\ufeff\n {text}"])
def test_stl_in_upper_case_or_with_a_byte_order_mark_is_read(tmp_path, change):
    path = write_raw(tmp_path, "stl as text", VERTICES, FACES)
    expected = path.read_bytes()
    path.write_bytes(change(expected.decode()).encode())
    found = inspect(path)
    assert (path.read_bytes() if found.readable is None else found.readable).endswith(expected)


@pytest.mark.parametrize("has_base", [True, False])
@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (3, 2.0, None),
        (3, np.nan, "1 vertices have coordinates that are not finite numbers: 3"),
        (len(VERTICES), 2.0, "a sparse accessor replaces 1 values that do not exist: 0"),
    ],
)
def test_sparse_accessors_are_looked_into(tmp_path, has_base, place, value, message):
    path = tmp_path / "sparse.glb"
    sparse = struct.pack("<I3f", place, value, 0, 0)

    def change(scene):
        start = scene["buffers"][0]["byteLength"]
        scene["buffers"][0]["byteLength"] += len(sparse)
        scene["bufferViews"] += [
            {"buffer": 0, "byteOffset": start, "byteLength": 4},
            {"buffer": 0, "byteOffset": start + 4, "byteLength": 12},
        ]
        indices, values = {"bufferView": 2, "componentType": 5125}, {"bufferView": 3}
        position = scene["accessors"][0]
        position["sparse"] = {"count": 1, "indices": indices, "values": values}
        if not has_base:
            del position["bufferView"]

    path.write_bytes(glb_bytes(VERTICES, FACES, change=change, more=sparse))
    if message is None:
        assert inspect(path).n_points == len(VERTICES)
    else:
        with pytest.raises(FileError, match=message):
            inspect(path)


def test_a_sparse_accessor_that_lies_is_refused(tmp_path):
    path = tmp_path / "sparse.glb"

    def change(scene):
        part = {"bufferView": 1, "componentType": 5125}
        sparse = {"count": 1, "indices": part, "values": {"bufferView": 1}}
        scene["accessors"][0] |= {"count": 4_000_000_000, "sparse": sparse}
        del scene["accessors"][0]["bufferView"]

    path.write_bytes(glb_bytes(VERTICES, FACES, change=change))
    with pytest.raises(FileError, match="accessor 0 promises 4000000000 elements"):
        inspect(path)
