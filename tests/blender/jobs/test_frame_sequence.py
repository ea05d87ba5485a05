"""Frames of one surface: files, caches and animations in, mesh sequences and keyed objects out."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import bpy
import numpy as np
import pytest
from support.batches import batch, summary
from support.meshes import graded_sphere, random_closed
from support.objects import add_object, keyframe_motion, shown_positions, world_positions

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.files.mesh_files import (
    empty_scene,
    export_mesh,
    import_mesh,
    save_blend,
)
from adaptive_fairing.blender.jobs.frames import evaluated_mesh, object_at_frame
from adaptive_fairing.blender.jobs.keyed_object import write_frame_keys
from adaptive_fairing.core import FairingError, FairingSettings, fair

THOROUGH = pytest.mark.thorough

FRAMES = (1, 2, 3, 4)
STRETCH = 3.0  # of the box, from the first frame to the last
FLOAT32 = 2.0**-21  # rounding of coordinates up to 8, a few times over
# With the area for density the result does not depend on the box of the mesh, which is another one
# once the object is turned.
SETTINGS = ("--steps", 2, "--density", "area")


def run(*arguments, algorithm="denoise"):
    return batch(*arguments, "--quiet", algorithm=algorithm)


def read_ply(path):
    return read_positions(import_mesh(path).data)


def animated_bean():
    """Add a noisy ball that is stretched by a shape key, turned and moved; with UVs."""
    vertices, faces = graded_sphere(2)
    noise = np.random.default_rng(1).normal(scale=0.02, size=vertices.shape)
    obj = add_object(vertices + noise, faces, "Bean")
    obj.data.uv_layers.new(name="UVMap")
    obj.data.materials.append(bpy.data.materials.new("Skin"))
    obj.shape_key_add(name="Basis", from_mix=False)
    key = obj.shape_key_add(name="Long", from_mix=False)
    long = (vertices + noise) * [STRETCH, 1, 1]
    key.points.foreach_set("co", long.astype(np.float32).ravel())
    for frame, amount in ((FRAMES[0], 0.0), (FRAMES[-1], 1.0)):
        key.value = amount
        key.keyframe_insert("value", frame=frame)
        keyframe_motion(obj, frame, amount)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
    return obj


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """Give the same animation in every form that Blender reads, by kind."""
    folder = tmp_path_factory.mktemp("sources")
    empty_scene()
    obj = animated_bean()
    paths = {kind: folder / f"bean{kind}" for kind in (".blend", ".abc", ".usdc")}
    save_blend(paths[".blend"])
    first, last = FRAMES[0], FRAMES[-1]
    bpy.ops.wm.alembic_export(
        filepath=str(paths[".abc"]), start=first, end=last, as_background_job=False
    )
    bpy.ops.wm.usd_export(filepath=str(paths[".usdc"]), export_animation=True)
    for suffix in (".obj", ".ply", ".stl", ".glb", ".gltf", ".usda"):
        files = folder / f"files{suffix}"
        files.mkdir()
        for frame in FRAMES:
            obj = import_mesh(paths[".blend"])
            export_mesh(object_at_frame(obj, frame), files / f"bean_{frame}{suffix}", alone=True)
        paths[f"files{suffix}"] = files
    paths["cache"] = point_cache(folder, paths["files.ply"])
    return paths


def point_cache(folder, files):
    """Write a .pc2 point cache and a .blend whose object is moved by it; its own shape is flat."""
    shapes = [read_ply(files / f"bean_{frame}.ply") for frame in FRAMES]
    header = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(shapes[0]), 1.0, 1.0, len(shapes))
    cache = folder / "bean.pc2"
    cache.write_bytes(header + np.array(shapes, dtype="<f4").tobytes())
    obj = import_mesh(files / "bean_1.ply")
    obj.data.transform([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]])
    modifier = obj.modifiers.new("Cache", "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = str(cache)
    modifier.frame_start = FRAMES[0]
    save_blend(folder / "cached.blend")
    return folder / "cached.blend"


@pytest.fixture(scope="module")
def expected(sources):
    """Give the faired frames in the world, made without files by the core."""
    settings = FairingSettings(steps=2, density="area")
    shapes = []
    for frame in FRAMES:
        mesh, matrix = evaluated_mesh(import_mesh(sources[".blend"]), frame)
        data = read_mesh(mesh)
        faired = fair(data.vertices, data.triangles, settings).positions
        matrix = np.array(matrix)
        shapes.append(faired @ matrix[:3, :3].T + matrix[:3, 3])
    return shapes


def nearest_distance(points, others):
    """Largest distance of a point to the nearest of others: for files that renumber vertices."""
    return max(np.linalg.norm(others - point, axis=1).min() for point in points)


@pytest.mark.parametrize("kind", [".blend", ".abc", ".usdc", "cache"])
def test_frames_of_an_animation_are_faired_as_they_are_shown(sources, expected, tmp_path, kind):
    frames = f"{FRAMES[0]}-{FRAMES[-1]}"
    assert (
        run(sources[kind], "--frames", frames, "--out-dir", tmp_path, *SETTINGS, algorithm="fair")
        == 0
    )
    stem = sources[kind].stem
    for frame, shape in zip(FRAMES, expected, strict=True):
        found = read_ply(tmp_path / f"{stem}_{frame:04d}.ply")
        np.testing.assert_allclose(found, shape, rtol=0, atol=20 * FLOAT32)


@pytest.mark.parametrize(
    "suffix",
    [
        ".obj",
        ".ply",
        ".glb",
        *(pytest.param(s, marks=THOROUGH) for s in (".stl", ".gltf", ".usda")),
    ],
)
def test_numbered_files_are_faired_each(sources, expected, tmp_path, suffix):
    """Compared through the format itself, because some turn axes, round, or renumber."""
    given = sources[f"files{suffix}"]
    arguments = (given, "--sequence", "--out-dir", tmp_path, *SETTINGS)
    assert run(*arguments, algorithm="fair") == 0
    for frame, shape in zip(FRAMES, expected, strict=True):
        found = world_positions(import_mesh(tmp_path / f"bean_{frame}{suffix}"))
        digits = 1e-5 if suffix == ".obj" else 20 * FLOAT32
        assert nearest_distance(shape, found) < digits


def test_the_first_frame_has_the_bytes_that_it_has_alone(sources, tmp_path):
    given = sources["files.obj"]
    assert run(given, "--sequence", "--out-dir", tmp_path / "all") == 0
    (tmp_path / "one").mkdir()
    assert run(given / "bean_1.obj", "-o", tmp_path / "one" / "bean_1.obj") == 0
    for name in ("bean_1.obj", "bean_1.mtl"):
        assert (tmp_path / "all" / name).read_bytes() == (tmp_path / "one" / name).read_bytes()


@pytest.mark.parametrize(
    ("algorithm", "options"),
    [
        pytest.param("denoise", [], marks=THOROUGH),
        ("fair", ["--same-strength", "--stop-curvature", "0.775"]),
        pytest.param("denoise", ["--same-strength"], marks=THOROUGH),
    ],
)
def test_it_does_not_matter_where_a_frame_is_faired(sources, tmp_path, algorithm, options):
    """In one process, in two, or as shards on several machines: the same bytes."""

    def fair_into(folder, *more):
        common = (sources[".blend"], "--frames", "1-4", *options)
        assert run(*common, "--out-dir", tmp_path / folder, *more, algorithm=algorithm) == 0

    fair_into("one")
    fair_into("two", "--jobs", 2)
    for shard in ("2/2", "1/2"):
        fair_into("shards", "--shard", shard)
    fair_into("shards", "--merge")
    names = [f"bean_{frame:04d}.ply" for frame in FRAMES]
    for name in names:
        found = {(tmp_path / folder / name).read_bytes() for folder in ("one", "two", "shards")}
        assert len(found) == 1, name


def test_same_strength_takes_the_first_frames_number_of_steps_and_tau(sources, tmp_path):
    """Frames of another shape end after other steps, and the radius asks for another τ in them."""
    report = tmp_path / "r.json"
    common = (sources[".blend"], "--frames", "1-4", "--report", report)
    common += ("--stop-curvature", "0.775", "--steps", "9")

    def told(folder, *options):
        assert run(*common, "--out-dir", tmp_path / folder, *options, algorithm="fair") == 0
        frames = json.loads(report.read_text())["meshes"]
        return [[frame[name] for frame in frames] for name in ("steps", "tau")]

    steps, taus = told("each")
    assert len(set(steps)) > 1, "no test: the frames would do with the same number anyway"
    assert len(set(taus)) == len(FRAMES)
    same = [[each[0]] * len(FRAMES) for each in (steps, taus)]
    assert told("same", "--same-strength") == same


def test_one_strength_or_each_its_own_are_different_results(sources, tmp_path):
    """Asked for later, what was made without is made anew."""
    # So small a mesh counts as a clean model otherwise.
    common = [sources[".blend"], "--frames", "1-4", "--out-dir", tmp_path, "--clean", "denoise"]
    last = tmp_path / "bean_0004.ply"
    assert run(*common) == 0
    before = last.read_bytes()
    assert run(*common, "--same-strength") == 0
    assert last.read_bytes() != before


def growing_files(folder):
    """Write three frames, of which the third has other triangles."""
    folder.mkdir()
    for frame, mesh in enumerate([random_closed(1), random_closed(1), graded_sphere(2)], start=1):
        empty_scene()
        export_mesh(add_object(mesh[0] * frame, mesh[1]), folder / f"f_{frame}.ply", alone=True)
    return folder


def test_a_frame_with_other_triangles_is_faired_as_if_alone(tmp_path):
    given = growing_files(tmp_path / "given")
    assert run(given, "--sequence", "--out-dir", tmp_path / "out") == 0
    assert run(given / "f_3.ply", "-o", tmp_path / "f_3.ply") == 0
    assert (tmp_path / "out/f_3.ply").read_bytes() == (tmp_path / "f_3.ply").read_bytes()


def test_frames_of_different_topology_become_no_keyed_object(tmp_path, capsys):
    given = growing_files(tmp_path / "given")
    assert run(given, "--sequence", "-o", tmp_path / "all.blend") == 1
    assert "f_3.ply has 162 vertices, f_1.ply has 42" in capsys.readouterr().err
    assert not (tmp_path / "all.blend").exists()
    assert (tmp_path / "all_frames/f_3.ply").exists()


def is_shown_mesh(obj):
    return obj.type == "MESH" and obj.visible_get()


@pytest.mark.parametrize(
    "kind",
    [
        ".blend",
        ".abc",
        "files.obj",
        *(pytest.param(k, marks=THOROUGH) for k in (".usdc", "files.ply")),
    ],
)
def test_one_keyed_object_shows_every_frame(sources, expected, tmp_path, kind):
    given = sources[kind]
    how = ["--frames", "1-4"] if given.is_file() else ["--sequence"]
    assert run(given, *how, "-o", tmp_path / "all.blend", *SETTINGS, algorithm="fair") == 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "all.blend"))
    (obj,) = [each for each in bpy.context.view_layer.objects if is_shown_mesh(each)]
    keys = obj.data.shape_keys
    assert [block.name for block in keys.key_blocks] == [f"Frame {frame}" for frame in FRAMES]
    assert not keys.use_relative
    for frame, shape in zip(FRAMES, expected, strict=True):
        bpy.context.scene.frame_set(frame)
        found = world_positions(obj)
        digits = 1e-5 if kind == "files.obj" else 20 * FLOAT32
        np.testing.assert_allclose(found, shape, rtol=0, atol=digits)
    n_uv_layers = 0 if kind == "files.ply" else 1
    assert len(obj.data.uv_layers) == n_uv_layers
    assert (bpy.context.scene.frame_start, bpy.context.scene.frame_end) == (FRAMES[0], FRAMES[-1])


def test_the_animated_object_stays_hidden_beside_the_keyed_one(sources, tmp_path):
    assert run(sources[".blend"], "--frames", "1-2", "-o", tmp_path / "all.blend") == 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "all.blend"))
    assert sorted(obj.name for obj in bpy.data.objects) == ["Bean", "Bean denoised"]
    assert not bpy.data.objects["Bean"].visible_get()
    assert bpy.data.objects["Bean"].hide_render
    assert [block.name for block in bpy.data.objects["Bean"].data.shape_keys.key_blocks] == [
        "Basis", "Long",
    ]  # fmt: skip


def test_between_two_frames_the_keyed_object_is_between():
    vertices, faces = random_closed(1)
    obj = add_object(vertices, faces)
    write_frame_keys(obj, [10, 20], [vertices, vertices + 1])
    bpy.context.scene.frame_set(15)
    np.testing.assert_allclose(shown_positions(obj), vertices + 0.5, atol=1e-5)


def test_a_missing_frame_is_told_and_nothing_is_put_together(sources, tmp_path, capsys):
    files = [sources["files.ply"] / f"bean_{frame}.ply" for frame in (1, 2)]
    missing = sources["files.ply"] / "bean_7.ply"
    assert run(*files, missing, "--sequence", "-o", tmp_path / "all.blend") == 1
    assert "bean_7.ply: cannot read" in capsys.readouterr().err
    assert not (tmp_path / "all.blend").exists()


def test_an_object_without_faces_at_a_frame_is_refused():
    obj = add_object(*random_closed(1))
    obj.modifiers.new("Gone", "MASK").vertex_group = obj.vertex_groups.new(name="none").name
    with pytest.raises(FairingError, match="'Thing' has no faces at frame 3"):
        object_at_frame(obj, 3)


def test_settings_of_the_whole_sequence_that_fail_are_told(tmp_path, capsys):
    bad = tmp_path / "f_1.ply"
    bad.write_text("no mesh")
    export_mesh(add_object(*random_closed(1)), tmp_path / "f_2.ply", alone=True)
    arguments = (tmp_path, "--sequence", "--same-strength", "--out-dir", tmp_path / "out")
    assert run(*arguments) == 1
    assert "first frame, f_1.ply: cannot read" in capsys.readouterr().err
    # On a farm no worker is to blame, neither for the frames nor for what sums them up.
    for task in ("--jobs=1", "--merge"):
        assert run(*arguments, task, "--allow-failures", "--report", tmp_path / "r.json") == 0
        assert "note: 2 of 2 meshes have no output, the first is f_1.ply: first frame, f_1" in (
            capsys.readouterr().err
        )
        assert summary(tmp_path / "r.json") == {"f_1.ply": "failed", "f_2.ply": "failed"}


def test_the_reports_name_object_and_frame(sources, tmp_path):
    report = tmp_path / "r.json"
    assert run(sources[".blend"], "--frames", "2", "--out-dir", tmp_path, "--report", report) == 0
    (mesh,) = json.loads(report.read_text())["meshes"]
    assert (mesh["frame"], mesh["output"]) == (2, "bean_0002.ply")
    assert Path(mesh["input"]) == sources[".blend"]
