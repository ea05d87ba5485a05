"""Files beside an output that nobody named: none is replaced, and what refers to them is true."""

import bpy
import numpy as np
import pytest
from support.folders import contents_of
from support.meshes import noisy_ball
from support.objects import add_object, add_rich_object

from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.files.mesh_files import (
    empty_scene,
    export_mesh,
    import_mesh,
    save_blend,
)
from adaptive_fairing.blender.jobs.file_job import FairingJob, run_job
from adaptive_fairing.files.formats import MESH_FORMATS

COMPANIONS = {
    ".obj": {"out.mtl"},
    ".gltf": {"out.bin", "wood.png"},
    ".usd": {"textures/wood.png"},
    ".usda": {"textures/wood.png"},
    ".usdc": {"textures/wood.png"},
}
"""What Blender writes beside a textured mesh; nothing beside the other formats."""

SIZE = 4


def add_textured(color, kind):
    """Add a ball whose texture has one colour, is called "wood", and lives in a way of its own."""
    obj = add_object(*noisy_ball(2, 0.02))
    obj.data.uv_layers.new(name="UVMap")
    image = bpy.data.images.new("wood" if kind == "made here" else "wood.png", SIZE, SIZE)
    image.pixels.foreach_set(np.tile(np.array([*color, 1], dtype=np.float32), SIZE * SIZE))
    if kind == "packed":
        image.pack()
    material = bpy.data.materials.new("Wood")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    obj.data.materials.append(material)
    return obj


def colors_of_textures():
    """First pixel of every image of the scene, as whole bytes."""
    return {
        tuple(np.round(255 * np.array(image.pixels[:3])).astype(int).tolist())
        for image in bpy.data.images
        if image.size[0]
    }


@pytest.mark.parametrize("kind", ["made here", "packed"])
@pytest.mark.parametrize("suffix", MESH_FORMATS)
def test_files_that_have_the_names_stay_and_the_output_finds_its_own(tmp_path, suffix, kind):
    out = tmp_path / f"out{suffix}"
    export_mesh(add_textured((1, 0, 0), kind), out, alone=True)
    names = set(contents_of(tmp_path)) - {out.name}
    assert names == COMPANIONS.get(suffix, set())
    for name in names:
        (tmp_path / name).write_bytes(b"of another program")
    before = contents_of(tmp_path)

    empty_scene()
    blue = add_textured((0, 0, 1), kind)
    expected = read_positions(blue.data)
    notes = export_mesh(blue, out, alone=True, keep_axes=True)

    after = contents_of(tmp_path)
    assert {name: after[name] for name in names} == {name: before[name] for name in names}
    assert len(after) == len(before) + len(names)
    told = [note for note in notes if "is taken by another file" in note]
    assert len(told) == len(names)
    for name in after.keys() - before.keys():
        assert any(name in note for note in told)
    back = import_mesh(out, keep_axes=True)
    assert {tuple(p) for p in read_positions(back.data)} == {tuple(p) for p in expected}
    if names and suffix != ".obj":  # Blender's .mtl names only images that are files
        assert colors_of_textures() == {(0, 0, 255)}
    if names:
        assert [material.name for material in back.data.materials] == ["Wood"]


@pytest.mark.parametrize("suffix", [".obj", ".gltf", ".usda"])
def test_a_second_run_that_writes_the_same_leaves_the_same_files(tmp_path, suffix):
    obj = add_textured((1, 0, 0), "packed")
    export_mesh(obj, tmp_path / f"out{suffix}", alone=True)
    before = contents_of(tmp_path)
    notes = export_mesh(obj, tmp_path / f"out{suffix}", alone=True)
    after = contents_of(tmp_path)
    assert after.keys() == before.keys()
    assert all(after[name] == before[name] for name in COMPANIONS[suffix])
    assert not any("taken" in note for note in notes)


def test_a_mesh_without_materials_gets_no_mtl_file(tmp_path):
    export_mesh(add_object(*noisy_ball(2, 0.02)), tmp_path / "part.obj", alone=True)
    assert list(contents_of(tmp_path)) == ["part.obj"]
    assert b"mtllib" not in (tmp_path / "part.obj").read_bytes()


def test_the_input_of_a_run_keeps_its_buffer(tmp_path):
    """a.gltf has its numbers in b.bin, which the output b.gltf would like to call its own."""
    export_mesh(add_object(*noisy_ball(3, 0.1)), tmp_path / "b.gltf", alone=True)
    (tmp_path / "b.gltf").rename(tmp_path / "a.gltf")
    before = contents_of(tmp_path)
    run_job(FairingJob(tmp_path / "a.gltf", tmp_path / "b.gltf"))
    after = contents_of(tmp_path)
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {"b.gltf", "b_2.bin"}


def test_a_textured_blend_leaves_the_textures_of_others_alone(tmp_path):
    given = tmp_path / "given.blend"
    add_textured((1, 0, 0), "packed")
    save_blend(given)
    (tmp_path / "textures").mkdir()
    (tmp_path / "textures" / "wood.png").write_bytes(b"of another program")
    before = contents_of(tmp_path)
    report = run_job(FairingJob(given, tmp_path / "out.usda"))
    after = contents_of(tmp_path)
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {"out.usda", "textures/wood_2.png"}
    assert any("textures/wood.png is taken by another file" in note for note in report["notes"])


@pytest.mark.parametrize("suffix", [".obj", ".gltf"])
def test_an_output_that_cannot_be_put_there_leaves_nothing_beside(tmp_path, suffix, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("adaptive_fairing.files.atomic_files._move", refuse)
    with pytest.raises(OSError, match="Permission denied"):
        export_mesh(add_rich_object(), tmp_path / f"out{suffix}", alone=True)
    assert contents_of(tmp_path) == {}
