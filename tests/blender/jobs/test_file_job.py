"""The main job: file in, faired file out, nothing else lost; its report."""

import json

import bpy
import numpy as np
import pytest
from support.meshes import boundary_vertices, bumpy_disc, icosphere, noisy_ball, random_closed
from support.objects import (
    add_object,
    add_rich_object,
    colors_by_vertex,
    key_positions,
    materials_by_polygon,
    numbers,
    polygons_of,
    shown_positions,
    uvs_by_corner,
    write_ply,
)

from adaptive_fairing.blender import compatibility
from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh, save_blend
from adaptive_fairing.blender.jobs.file_job import FRAMES_PER_STEP, FairingJob, run_job
from adaptive_fairing.core import DenoiseSettings, FairingSettings, denoise, fair
from adaptive_fairing.files.formats import MESH_FORMATS

SETTINGS = FairingSettings(tau=0.005, steps=2)


@pytest.fixture
def noisy(tmp_path):
    return write_ply(tmp_path / "noisy.ply", *random_closed(seed=1))


@pytest.fixture
def rich_blend(tmp_path):
    """A .blend with the rich object, which has a transform, and other things beside it."""
    obj = add_rich_object()
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.1, 0.2, 0.3), (1, 2, 0.5)
    group = obj.vertex_groups.new(name="Half")
    group.add(list(range(20)), 0.5, "REPLACE")
    obj.modifiers.new("Subdivision", "SUBSURF")
    obj["note"] = "keep me"
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    bpy.context.scene.collection.objects.link(lamp)
    lamp.keyframe_insert("location", frame=77)
    bpy.context.scene.frame_end = 90
    path = tmp_path / "rich.blend"
    save_blend(path)
    return path


def test_the_result_is_that_of_the_core(noisy, tmp_path):
    run_job(FairingJob(noisy, tmp_path / "out.blend", SETTINGS))
    data = read_mesh(import_mesh(noisy).data)
    expected = fair(data.vertices, data.triangles, SETTINGS)
    obj = import_mesh(tmp_path / "out.blend")
    np.testing.assert_array_equal(key_positions(obj, "Basis"), data.vertices)
    for step in expected.steps:
        np.testing.assert_array_equal(
            key_positions(obj, f"Fairing {step.index}"), step.positions.astype(np.float32)
        )
    density = expected.steps[-1].density.astype(np.float32)
    np.testing.assert_array_equal(numbers(obj.data, "fairing_density"), density)


def test_the_saved_file_opens_on_the_result_and_plays_the_evolution(noisy, tmp_path):
    run_job(FairingJob(noisy, tmp_path / "out.blend", SETTINGS))
    obj = import_mesh(tmp_path / "out.blend")
    scene = bpy.context.scene
    assert (scene.frame_start, scene.frame_end) == (1, 1 + 2 * FRAMES_PER_STEP)
    assert scene.frame_current == scene.frame_end
    assert obj.data.shape_keys.use_relative is False
    np.testing.assert_array_equal(shown_positions(obj), key_positions(obj, "Fairing 2"))
    for step, name in enumerate(("Basis", "Fairing 1", "Fairing 2")):
        scene.frame_set(1 + step * FRAMES_PER_STEP)
        np.testing.assert_array_equal(shown_positions(obj), key_positions(obj, name))
    (curve,) = compatibility.fcurves(obj.data.shape_keys)
    assert {point.interpolation for point in curve.keyframe_points} == {"LINEAR"}


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".fbx", ".usda"])
def test_a_mesh_format_gets_the_last_step_in_vertex_order(noisy, tmp_path, suffix):
    run_job(FairingJob(noisy, tmp_path / f"out{suffix}", SETTINGS))
    data = read_mesh(import_mesh(noisy).data)
    expected = fair(data.vertices, data.triangles, SETTINGS).positions.astype(np.float32)
    obj = import_mesh(tmp_path / f"out{suffix}", keep_axes=True)
    np.testing.assert_array_equal(read_positions(obj.data), expected)
    assert [a.name for a in obj.data.attributes if "fairing" in a.name] == []


def test_stl_in_and_out(tmp_path):
    vertices, faces = random_closed(seed=2)
    export_mesh(add_object(vertices, faces), tmp_path / "in.stl", alone=True)
    run_job(FairingJob(tmp_path / "in.stl", tmp_path / "out.stl", SETTINGS))
    data = read_mesh(import_mesh(tmp_path / "in.stl").data)
    expected = fair(data.vertices, data.triangles, SETTINGS).positions.astype(np.float32)
    found = read_mesh(import_mesh(tmp_path / "out.stl").data)
    np.testing.assert_array_equal(found.vertices[found.triangles], expected[data.triangles])


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_split_vertices_of_gltf_move_as_one(tmp_path, suffix):
    vertices, faces = random_closed(seed=3)
    vertices = vertices.astype(np.float32)
    # Flat shading: every vertex is stored once per triangle around it.
    export_mesh(add_object(vertices, faces), tmp_path / f"in{suffix}", alone=True)
    assert len(import_mesh(tmp_path / f"in{suffix}").data.vertices) > 2 * len(vertices)
    run_job(FairingJob(tmp_path / f"in{suffix}", tmp_path / f"out{suffix}", SETTINGS))
    found = read_positions(import_mesh(tmp_path / f"out{suffix}").data)
    expected = fair(vertices, faces, SETTINGS).positions
    # Vertex order decides the rounding in the solver, so the last bits may differ.
    distance = np.linalg.norm(found[:, None] - expected[None], axis=2)
    assert len(np.unique(found, axis=0)) == len(vertices)
    assert distance.min(axis=1).max() < 1e-5
    assert distance.min(axis=0).max() < 1e-5


@pytest.mark.parametrize("source", [".obj", ".ply"])
@pytest.mark.parametrize("result", [".obj", ".ply"])
def test_vertices_that_stay_keep_their_coordinates_in_the_file(tmp_path, source, result):
    vertices, faces = bumpy_disc(seed=0)
    given = tmp_path / f"in{source}"
    export_mesh(add_object(1e-3 * vertices, faces), given, alone=True, keep_axes=True)
    run_job(FairingJob(given, tmp_path / f"out{result}", SETTINGS))
    found = read_positions(import_mesh(tmp_path / f"out{result}", keep_axes=True).data)
    held = boundary_vertices(faces)
    np.testing.assert_array_equal(found[held], (1e-3 * vertices).astype(np.float32)[held])
    assert np.abs(found - 1e-3 * vertices).max() > 1e-6


def test_an_obj_stands_upright_in_a_blend(tmp_path):
    vertices, faces = random_closed(seed=1)
    export_mesh(add_object(vertices, faces), tmp_path / "in.obj", alone=True)
    run_job(FairingJob(tmp_path / "in.obj", tmp_path / "out.blend", SETTINGS))
    obj = import_mesh(tmp_path / "out.blend")
    up = np.array(obj.matrix_world)[:3, :3] @ (0, 1, 0)
    np.testing.assert_allclose(up, (0, 0, 1), atol=1e-6)


def test_a_blend_keeps_everything_else(rich_blend, tmp_path):
    obj = import_mesh(rich_blend)
    before = {
        "polygons": polygons_of(obj.data),
        "uv": uvs_by_corner(obj.data),
        "paint": colors_by_vertex(obj.data, "Paint"),
        "heat": numbers(obj.data, "heat"),
        "materials": materials_by_polygon(obj.data),
        "matrix": np.array(obj.matrix_world),
        "positions": read_positions(obj.data),
    }
    run_job(FairingJob(rich_blend, tmp_path / "out.blend", SETTINGS))
    obj = import_mesh(tmp_path / "out.blend")
    mesh = obj.data
    assert obj.name == "Thing"
    assert polygons_of(mesh) == before["polygons"]
    after_uv = uvs_by_corner(mesh)
    for polygon, uv in before["uv"].items():
        np.testing.assert_array_equal(after_uv[polygon], uv)
    np.testing.assert_array_equal(colors_by_vertex(mesh, "Paint"), before["paint"])
    np.testing.assert_array_equal(numbers(mesh, "heat"), before["heat"])
    assert materials_by_polygon(mesh) == before["materials"]
    np.testing.assert_array_equal(np.array(obj.matrix_world), before["matrix"])
    np.testing.assert_array_equal(key_positions(obj, "Basis"), before["positions"])
    assert [modifier.type for modifier in obj.modifiers] == ["SUBSURF"]
    assert obj["note"] == "keep me"
    assert [group.name for group in obj.vertex_groups] == ["Half"]
    assert [group.weight for group in mesh.vertices[0].groups] == [0.5]
    (curve, *_) = compatibility.fcurves(bpy.data.objects["Lamp"])
    assert curve.keyframe_points[0].co[0] == 77
    assert bpy.context.scene.frame_end == 90, "the range of other animation is not cut"


def test_a_second_run_on_the_result_starts_from_the_same_input(noisy, tmp_path):
    run_job(FairingJob(noisy, tmp_path / "one.blend", SETTINGS))
    one = import_mesh(tmp_path / "one.blend")
    first = [key_positions(one, name) for name in ("Basis", "Fairing 1", "Fairing 2")]
    run_job(FairingJob(tmp_path / "one.blend", tmp_path / "two.blend", SETTINGS))
    two = import_mesh(tmp_path / "two.blend")
    assert len(two.data.shape_keys.key_blocks) == 3
    for name, positions in zip(("Basis", "Fairing 1", "Fairing 2"), first, strict=True):
        np.testing.assert_array_equal(key_positions(two, name), positions)


@pytest.mark.parametrize(
    ("settings", "name", "n_keys"),
    [(SETTINGS, "Face faired", 3), (DenoiseSettings(clean="denoise"), "Face denoised", 6)],
)
def test_keys_of_the_user_stay_beside_a_copy(tmp_path, settings, name, n_keys):
    obj = add_object(*random_closed(seed=1), name="Face")
    obj.shape_key_add(name="Basis")
    smile = obj.shape_key_add(name="Smile")
    smile.points[0].co = (7, 7, 7)
    save_blend(tmp_path / "in.blend")
    run_job(FairingJob(tmp_path / "in.blend", tmp_path / "out.blend", settings))
    import_mesh(tmp_path / "out.blend", name)
    face, copy = bpy.data.objects["Face"], bpy.data.objects[name]
    assert [block.name for block in face.data.shape_keys.key_blocks] == ["Basis", "Smile"]
    assert tuple(key_positions(face, "Smile")[0]) == (7, 7, 7)
    assert len(copy.data.shape_keys.key_blocks) == n_keys
    assert face.hide_get()


def test_keys_of_the_user_do_not_show_in_a_mesh_file(tmp_path):
    vertices, faces = bumpy_disc(seed=0)
    obj = add_object(vertices, faces, name="Face")
    obj.shape_key_add(name="Basis")
    smile = obj.shape_key_add(name="Smile")
    smile.points[0].co = (7, 7, 7)
    smile.value = 1.0
    save_blend(tmp_path / "in.blend")
    run_job(FairingJob(tmp_path / "in.blend", tmp_path / "out.ply", SETTINGS))
    expected = fair(vertices.astype(np.float32), faces, SETTINGS).positions
    found = read_positions(import_mesh(tmp_path / "out.ply").data)
    np.testing.assert_array_equal(found, expected.astype(np.float32))


def test_the_input_may_be_the_output(rich_blend):
    run_job(FairingJob(rich_blend, rich_blend, SETTINGS))
    assert len(import_mesh(rich_blend).data.shape_keys.key_blocks) == 3
    assert [file.name for file in rich_blend.parent.iterdir()] == ["rich.blend"]


class TestDenoise:
    """What `denoise` writes: the strength asked for as the result, all of them as keys."""

    settings = DenoiseSettings(strength=0.8)

    @pytest.fixture
    def given(self, tmp_path):
        return write_ply(tmp_path / "ball.ply", *noisy_ball())

    @pytest.fixture
    def expected(self, given):
        data = read_mesh(import_mesh(given).data)
        return denoise(data.vertices, data.triangles, self.settings)

    def test_a_mesh_format_gets_the_strength_asked_for(self, given, expected, tmp_path):
        parts = []
        job = FairingJob(given, tmp_path / "out.ply", self.settings)
        report = run_job(job, on_fraction_done=parts.append)
        found = read_positions(import_mesh(tmp_path / "out.ply").data)
        np.testing.assert_array_equal(found, expected.positions.astype(np.float32))
        assert parts == sorted(parts)
        assert parts[-1] == 1.0
        assert report["algorithm"] == "denoise"
        assert report["denoise"]["noise"] == expected.noise_level
        assert (report["steps"], report["stop_reason"]) == ([], None)

    def test_a_blend_file_shows_it_among_the_others(self, given, expected, tmp_path):
        run_job(FairingJob(given, tmp_path / "out.blend", self.settings))
        obj = import_mesh(tmp_path / "out.blend")
        for number, shape in enumerate(expected.shapes, start=1):
            found = key_positions(obj, f"Fairing {number}")
            np.testing.assert_array_equal(found, shape.astype(np.float32))
        bpy.context.scene.frame_set(bpy.context.scene.frame_current)
        np.testing.assert_allclose(shown_positions(obj), expected.positions, atol=1e-6)


def test_loose_parts_stay_where_they_are(tmp_path):
    vertices, faces = icosphere(2)
    path = write_ply(tmp_path / "in.ply", np.vstack([vertices, [(5, 6, 7)]]), faces)
    run_job(FairingJob(path, tmp_path / "out.ply", SETTINGS))
    found = read_positions(import_mesh(tmp_path / "out.ply").data)
    np.testing.assert_array_equal(found[-1], (5, 6, 7))


def test_the_report_says_what_was_asked_and_measured(noisy, tmp_path):
    report = tmp_path / "report.json"
    run_job(FairingJob(noisy, tmp_path / "out.ply", SETTINGS, report=report))
    written = json.loads(report.read_text(encoding="utf-8"), parse_constant=pytest.fail)

    data = read_mesh(import_mesh(noisy).data)
    expected = fair(data.vertices, data.triangles, SETTINGS)
    assert written["program"]["blender"] == bpy.app.version_string
    assert written["input"] == str(noisy)
    assert written["output"] == str(tmp_path / "out.ply")
    assert written["object"] == "noisy"
    assert written["settings"]["tau"] == 0.005
    assert written["settings"]["scheme"] == "timestep"
    assert written["mesh"] == {
        "vertices": len(data.vertices),
        "edges": 3 * len(data.triangles) // 2,
        "polygons": len(data.triangles),
        "triangles": len(data.triangles),
    }
    assert written["initial"]["area"] == expected.initial.area
    assert written["stop_reason"] == "steps"
    assert written["error"] is None
    assert len(written["steps"]) == 2
    for step, record in zip(expected.steps, written["steps"], strict=True):
        moved = np.linalg.norm(np.float32(step.positions) - data.vertices, axis=1)
        seconds = record.pop("seconds")
        assert seconds > 0
        assert record == {
            "step": step.index,
            "tau": 0.005,
            "time": step.index * 0.005,
            "cg_iterations": step.solve.iterations,
            "cg_residual": step.solve.residual,
            "converged": True,
            "curvature_energy": step.curvature_energy,
            "curvature_ratio": step.curvature_ratio,
            "area": step.area,
            "volume": step.volume,
            "largest_displacement": moved.max(),
            "mean_displacement": moved.mean(),
        }


def test_the_volume_of_an_open_surface_is_null(tmp_path):
    path = write_ply(tmp_path / "in.ply", *bumpy_disc(seed=0))
    report = tmp_path / "report.json"
    run_job(FairingJob(path, tmp_path / "out.ply", SETTINGS, report=report))
    written = json.loads(report.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert written["initial"]["volume"] is None
    assert written["steps"][0]["volume"] is None


def test_steps_are_announced(noisy, tmp_path):
    seen = []
    run_job(
        FairingJob(noisy, tmp_path / "out.ply", SETTINGS),
        lambda solve: seen.append(len(solve.steps)),
    )
    assert seen == [1, 2]


@pytest.mark.parametrize("suffix", [".blend", *MESH_FORMATS])
def test_every_format_goes_in_and_out(noisy, tmp_path, suffix):
    run_job(FairingJob(noisy, tmp_path / f"one{suffix}", SETTINGS))
    run_job(FairingJob(tmp_path / f"one{suffix}", tmp_path / f"two{suffix}", SETTINGS))
    assert len(import_mesh(tmp_path / f"two{suffix}").data.polygons) == 80
