"""First sight of an output .blend: its colours, its views, and the object beside the result."""

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support.meshes import icosphere
from support.objects import add_rich_object, write_ply

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.files.mesh_files import import_mesh, save_blend
from adaptive_fairing.blender.jobs.file_job import FairingJob, run_job
from adaptive_fairing.core import DenoiseSettings, FairingSettings, denoise

SETTINGS = FairingSettings(tau=0.002, steps=1)
DENSITY_COLOR = "fairing_density_color"


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    """Give the places of a noisy sphere and of one without noise."""
    folder = tmp_path_factory.mktemp("meshes")
    vertices, faces = icosphere(4)
    noise = np.random.default_rng(5).normal(0.0, 0.015, len(vertices))
    write_ply(folder / "noisy.ply", vertices * (3.0 + noise[:, None]), faces)
    write_ply(folder / "clean.ply", vertices, faces)
    return folder


def _opened(source, output, **options):
    """Objects of the output of a job, and its notes."""
    notes = run_job(FairingJob(source, output, SETTINGS, **options))["notes"]
    bpy.ops.wm.open_mainfile(filepath=str(output))
    return {obj.name: obj for obj in bpy.context.scene.objects}, notes


def test_what_denoise_makes_of_it_stands_beside(meshes, tmp_path):
    source = meshes / "noisy.ply"
    expected = denoise(*_arrays(source), DenoiseSettings())
    assert expected.is_changed
    objects, notes = _opened(source, tmp_path / "out.blend", denoised_beside=True)
    faired, beside = objects["noisy"], objects["noisy denoised"]
    np.testing.assert_array_equal(
        read_positions(beside.data), expected.positions.astype(np.float32)
    )
    assert beside.data.shape_keys is None
    assert DENSITY_COLOR not in beside.data.attributes
    assert len(faired.data.shape_keys.key_blocks) == 1 + SETTINGS.steps
    assert any("'noisy denoised'" in note for note in notes)
    # They do not meet.
    right = max(point.co.x for point in faired.data.shape_keys.key_blocks[0].points)
    assert right < beside.location.x + read_positions(beside.data)[:, 0].min()


def test_a_mesh_that_denoise_leaves_alone_stands_alone(meshes, tmp_path):
    objects, notes = _opened(meshes / "clean.ply", tmp_path / "out.blend", denoised_beside=True)
    assert list(objects) == ["clean"]
    assert any("leaves this mesh as it is" in note for note in notes)


def test_its_progress_is_told(meshes, tmp_path):
    job = FairingJob(meshes / "noisy.ply", tmp_path / "out.blend", SETTINGS, denoised_beside=True)
    parts = []
    run_job(job, on_fraction_done=parts.append)
    assert len(parts) > 3
    assert max(parts) == 1.0


@pytest.mark.parametrize("options", [{"refine": 1}, {"settings": DenoiseSettings()}])
def test_a_refined_or_denoised_mesh_stands_alone(meshes, tmp_path, options):
    job = FairingJob(
        meshes / "noisy.ply",
        tmp_path / "out.blend",
        **{"settings": SETTINGS, "denoised_beside": True, **options},
    )
    run_job(job)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    assert [obj.name for obj in bpy.context.scene.objects] == ["noisy"]


@pytest.mark.parametrize("name", ["noisy", "clean"])
def test_nobody_stands_beside_unless_asked_for(meshes, tmp_path, name):
    objects, notes = _opened(meshes / f"{name}.ply", tmp_path / "out.blend")
    assert (list(objects), notes) == ([name], [])


def test_the_density_is_the_colour_of_views_and_renders(meshes, tmp_path):
    objects, _ = _opened(meshes / "noisy.ply", tmp_path / "out.blend")
    mesh = objects["noisy"].data
    assert mesh.attributes.active_color_name == DENSITY_COLOR
    assert mesh.attributes.default_color_name == DENSITY_COLOR
    (material,) = mesh.materials
    (colors,) = (node for node in material.node_tree.nodes if node.type == "ATTRIBUTE")
    assert colors.attribute_name == DENSITY_COLOR
    (link,) = colors.outputs["Color"].links
    assert (link.to_node.type, link.to_socket.name) == ("BSDF_PRINCIPLED", "Base Color")


def test_all_views_look_at_the_objects_in_their_colours(meshes, tmp_path):
    objects, _ = _opened(meshes / "noisy.ply", tmp_path / "out.blend", denoised_beside=True)
    corners = [obj.matrix_world @ Vector(c) for obj in objects.values() for c in obj.bound_box]
    views = [
        area.spaces.active
        for screen in bpy.data.screens
        for area in screen.areas
        if area.type == "VIEW_3D"
    ]
    assert views
    for view in views:
        assert (view.shading.color_type, view.shading.light) == ("VERTEX", "STUDIO")
        seen = view.region_3d
        # In the coordinates of the view the middle of the screen is 0, and the eye looks along -Z.
        turn = seen.view_rotation.inverted()
        for corner in corners:
            x, _, z = turn @ (corner - seen.view_location)
            depth = seen.view_distance - z
            assert view.clip_start < depth < view.clip_end
            assert abs(x) < 0.5 * 72.0 / view.lens * depth


def test_a_blend_of_the_user_keeps_its_views_and_its_colours(tmp_path):
    for area in bpy.data.screens["Layout"].areas:
        if area.type == "VIEW_3D":
            area.spaces.active.shading.color_type = "RANDOM"
            area.spaces.active.region_3d.view_distance = 3.0
    add_rich_object()
    save_blend(tmp_path / "in.blend")
    objects, notes = _opened(tmp_path / "in.blend", tmp_path / "out.blend", denoised_beside=True)
    assert (list(objects), notes) == (["Thing"], [])
    mesh = objects["Thing"].data
    assert mesh.attributes.active_color_name == "Paint"
    assert [material.name for material in mesh.materials] == ["Red", "Blue"]
    for area in bpy.data.screens["Layout"].areas:
        if area.type == "VIEW_3D":
            assert area.spaces.active.shading.color_type == "RANDOM"
            assert area.spaces.active.region_3d.view_distance == 3.0


def _arrays(path):
    data = read_mesh(import_mesh(path).data)
    return data.vertices, data.triangles
