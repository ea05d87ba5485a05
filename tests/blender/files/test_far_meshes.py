"""Meshes far from the origin, such as those of maps: no digit is lost on the way."""

import bpy
import numpy as np
import pytest
from support.meshes import noisy_ball
from support.raw_files import obj_bytes, ply_bytes, stl_bytes

from adaptive_fairing.batch.plan import Item
from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh
from adaptive_fairing.blender.jobs.file_job import FairingJob, run_job
from adaptive_fairing.blender.jobs.keyed_object import write_keyed_file
from adaptive_fairing.core import FairingSettings
from adaptive_fairing.files.inspection.ply import read_header, read_rows

PLACE = np.array([4_600_000.0, 1_200_000.0, 300.0])
SIZE = 50.0
DIGITS = 3
"""Decimals of the given coordinates, as surveyors write them."""

STEP = float(np.spacing(np.float32(SIZE)))
"""Of single precision near the origin; it is 0.5 where the mesh is."""


def far_ball():
    vertices, faces = noisy_ball(2, 0.02)
    return np.round(SIZE * vertices + PLACE, DIGITS), faces


def write_far(path, vertices=None):
    given, faces = far_ball()
    given = given if vertices is None else vertices
    if path.suffix == ".ply":
        path.write_bytes(ply_bytes(given, faces, number="double"))
    else:
        path.write_bytes(obj_bytes(given, faces, digits=17))
    return path


def read_file(path):
    """Coordinates as the file holds them."""
    if path.suffix == ".ply":
        data = path.read_bytes()
        columns = read_rows(data, read_header(data))["vertex"].columns
        return np.column_stack([columns[axis] for axis in "xyz"]).astype(float)
    lines = path.read_text().splitlines()
    return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)


def in_world(obj):
    matrix = np.array(obj.matrix_world, dtype=float)
    return read_positions(obj.data) @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize("source", [".ply", ".obj"])
@pytest.mark.parametrize("output", [".ply", ".obj"])
@pytest.mark.parametrize("keep_axes", [True, False])
def test_what_did_not_move_comes_out_as_it_went_in(tmp_path, source, output, keep_axes):
    given = write_far(tmp_path / f"a{source}")
    export_mesh(
        import_mesh(given, keep_axes=keep_axes),
        tmp_path / f"b{output}",
        alone=True,
        keep_axes=keep_axes,
    )
    found = read_file(tmp_path / f"b{output}")
    expected = far_ball()[0]
    if not keep_axes and source == ".obj" and output == ".ply":
        expected = np.stack([expected[:, 0], -expected[:, 2], expected[:, 1]], axis=1)
    if not keep_axes and source == ".ply" and output == ".obj":
        expected = np.stack([expected[:, 0], expected[:, 2], -expected[:, 1]], axis=1)
    np.testing.assert_array_equal(found, expected)


def test_single_precision_far_away_is_kept_bit_by_bit(tmp_path):
    vertices, faces = noisy_ball(2, 0.02)
    vertices = (300 * SIZE * vertices + PLACE).astype(np.float32)
    (tmp_path / "a.ply").write_bytes(ply_bytes(vertices, faces))
    export_mesh(import_mesh(tmp_path / "a.ply"), tmp_path / "b.ply", alone=True)
    found = read_file(tmp_path / "b.ply").astype(np.float32)
    np.testing.assert_array_equal(found, vertices)


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_a_run_gives_what_it_gives_near_the_origin(tmp_path, suffix):
    vertices, _ = far_ball()
    found = []
    for place in (0 * PLACE, PLACE):
        path = write_far(tmp_path / f"in{suffix}", vertices - PLACE + place)
        report = run_job(FairingJob(path, tmp_path / f"out{suffix}", FairingSettings(steps=2)))
        assert not any("rounded" in note for note in report["notes"])
        found.append(read_file(tmp_path / f"out{suffix}") - place)
    assert np.abs(found[0] - (vertices - PLACE)).max() > 1e4 * STEP, "no test"
    assert np.abs(found[1] - found[0]).max() <= 4 * STEP


@pytest.mark.parametrize("suffix", [".blend", ".glb", ".usda", ".abc", ".fbx"])
def test_formats_with_places_of_objects_keep_the_mesh(tmp_path, suffix):
    near = write_far(tmp_path / "near.ply", far_ball()[0] - PLACE)
    run_job(FairingJob(near, tmp_path / "expected.ply", FairingSettings(steps=1)))
    expected = read_file(tmp_path / "expected.ply") + PLACE
    path = write_far(tmp_path / "in.ply")
    run_job(FairingJob(path, tmp_path / f"out{suffix}", FairingSettings(steps=1)))
    obj = import_mesh(tmp_path / f"out{suffix}")
    bpy.context.view_layer.update()
    found = in_world(obj)
    if suffix == ".blend":
        key = obj.data.shape_keys.key_blocks[-1]
        flat = np.empty(3 * len(key.points), dtype=np.float32)
        key.points.foreach_get("co", flat)
        found = flat.reshape(-1, 3) + np.array(obj.location, dtype=float)
    distance = np.linalg.norm(found[:, None] - expected[None], axis=2)
    # Of a matrix that is not quite a turn by a right angle a few digits more are lost.
    assert distance.min(axis=0).max() < 0.01


def test_stl_tells_how_much_it_rounds(tmp_path):
    path = write_far(tmp_path / "in.ply")
    report = run_job(FairingJob(path, tmp_path / "out.stl", FairingSettings(steps=1)))
    assert any("coordinates are rounded to multiples of 0.5" in note for note in report["notes"])
    (tmp_path / "far.stl").write_bytes(stl_bytes(*far_ball(), form="ascii"))
    report = run_job(FairingJob(tmp_path / "far.stl", tmp_path / "out.ply", FairingSettings()))
    assert any("'far' are rounded to multiples of 0.5" in note for note in report["notes"])


def test_objects_of_an_obj_each_get_their_own_coordinates(tmp_path):
    vertices, faces = far_ball()
    loose = "v 4600000.125 1200000.125 300.125\n"
    text = obj_bytes(vertices, faces, digits=17, between=f"{loose}o One\n").decode()
    other = vertices + np.array([0, 0, 40.001])
    shift = len(vertices) + 1
    text += "o Two\n" + "".join("v {:.17g} {:.17g} {:.17g}\n".format(*point) for point in other)
    text += "".join("f {} {} {}\n".format(*(face + shift + 1)) for face in faces)
    (tmp_path / "two.obj").write_text(text)
    for name, expected in (("One", vertices), ("Two", other)):
        obj = import_mesh(tmp_path / "two.obj", name, keep_axes=True)
        assert np.abs(in_world(obj) - expected).max() <= 2 * STEP
    both = import_mesh(tmp_path / "two.obj", keep_axes=True)
    assert np.abs(in_world(both) - np.vstack([vertices, other])).max() <= 2 * STEP


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_frames_of_a_moving_mesh_become_one_object(tmp_path, suffix):
    """Each frame has an origin of its own."""
    vertices, _ = far_ball()
    moves, items = np.array([[0, 0, 0], [40.25, 0, 0], [80.5, -30, 7]]), []
    frames = [vertices + move for move in moves]
    for number, frame in enumerate(frames):
        given = write_far(tmp_path / f"in_{number}{suffix}", frame)
        output = write_far(tmp_path / f"out_{number}.ply", frame)
        items.append(Item(output.name, given, None, number, output, tmp_path / "none"))
    write_keyed_file(items, None, tmp_path / "all.blend")
    obj = import_mesh(tmp_path / "all.blend")
    for block, frame in zip(obj.data.shape_keys.key_blocks, frames, strict=True):
        flat = np.empty(3 * len(block.points), dtype=np.float32)
        block.points.foreach_get("co", flat)
        turn = np.round(np.array(obj.matrix_world)[:3, :3])
        found = (flat.reshape(-1, 3) @ turn.T + np.array(obj.location, dtype=float)) @ turn
        assert np.abs(found - frame).max() <= 4 * STEP
