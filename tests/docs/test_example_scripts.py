"""The scripts of examples/ do what they say, each in a Blender of its own."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from support.meshes import icosphere
from support.pages import ROOT

bpy = pytest.importorskip("bpy")

from support.objects import add_object, shown_positions, write_ply  # noqa: E402

from adaptive_fairing.blender.files.mesh_files import empty_scene, save_blend  # noqa: E402
from adaptive_fairing.blender.jobs.file_job import FairingJob, run_job  # noqa: E402
from adaptive_fairing.core import FairingSettings, denoise  # noqa: E402

EXAMPLES = ROOT / "examples"
AS_BLENDER = """
import runpy, sys
import bpy
opened, script, *rest = sys.argv[1:]
bpy.ops.wm.open_mainfile(filepath=opened)
sys.argv = ["blender", "-b", opened, "--python", script, "--", *rest]
runpy.run_path(script, run_name="__main__")
"""


def noisy_sphere(levels=4):
    """Vertices and triangles of a sphere with noise of a fifth of an edge."""
    vertices, faces = icosphere(levels)
    noise = np.random.default_rng(4).normal(0.0, 0.4 / 2**levels / 2, len(vertices))
    return (vertices * (1.0 + noise[:, None])).astype(np.float32), faces


def run(*command, resources):
    """Run Python on a command, with a Blender user directory of its own."""
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(resources)}
    done = subprocess.run(
        [sys.executable, *map(str, command)], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


def run_in_blender(opened, script, *rest, resources):
    """Run a script as `blender -b OPENED --python SCRIPT -- REST` does."""
    run("-c", AS_BLENDER, opened, EXAMPLES / script, *rest, resources=resources)


def pixels(path):
    """Pixels (height, width, 3) of a picture, from the lowest row on, as they are in the file."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    values = np.empty(4 * width * height, dtype=np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, 4)[:, :, :3]


@pytest.fixture(scope="module")
def resources(tmp_path_factory):
    """Give a user directory in which the extension is installed, as a link to the project."""
    directory = tmp_path_factory.mktemp("resources")
    repository = directory / "extensions" / "user_default"
    repository.mkdir(parents=True)
    (repository / "adaptive_fairing").symlink_to(ROOT, target_is_directory=True)
    return directory


@pytest.fixture
def two_meshes(tmp_path):
    """A .blend with a noisy sphere, a clean one, and a light."""
    empty_scene()
    add_object(*noisy_sphere(), name="Noisy")
    add_object(*icosphere(3), name="Clean").location.x = 3.0
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "SUN"))
    bpy.context.scene.collection.objects.link(light)
    save_blend(tmp_path / "in.blend")
    return tmp_path / "in.blend"


def test_denoise_blend_file(two_meshes, tmp_path, resources):
    run_in_blender(two_meshes, "denoise_blend_file.py", tmp_path / "out.blend", resources=resources)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    vertices, faces = noisy_sphere()
    expected = denoise(vertices.astype(np.float64), faces).positions.astype(np.float32)
    np.testing.assert_allclose(shown_positions(bpy.data.objects["Noisy"]), expected, atol=1e-5)
    clean = shown_positions(bpy.data.objects["Clean"])
    np.testing.assert_array_equal(clean, icosphere(3)[0].astype(np.float32))


def test_fair_blend_file(two_meshes, tmp_path, resources):
    run_in_blender(two_meshes, "fair_blend_file.py", tmp_path / "out.blend", resources=resources)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    for name in ("Noisy", "Clean"):
        mesh = bpy.data.objects[name].data
        assert [block.name for block in mesh.shape_keys.key_blocks] == [
            "Basis",
            *(f"Fairing {step}" for step in range(1, 5)),
        ]
        assert mesh.attributes["fairing_density"].data_type == "FLOAT"
        assert "fairing_density_color" in mesh.color_attributes


def test_render_evolution(tmp_path, resources):
    vertices, faces = noisy_sphere(3)
    # Half of it stretched, so that the density is not everywhere the same.
    source = write_ply(
        tmp_path / "egg.ply", vertices * [1, 1, 1] + (vertices > 0) * vertices, faces
    )
    run_job(FairingJob(source, tmp_path / "egg.blend", FairingSettings(steps=2, tau=0.01)))
    pictures = tmp_path / "pictures"
    options = ("--width", 90, "--samples", 4, "--every", 10)
    run_in_blender(
        tmp_path / "egg.blend", "render_evolution.py", pictures, *options, resources=resources
    )
    names = ["0000.png", "0001.png", "0002.png"]
    assert sorted(path.name for path in pictures.iterdir()) == names
    first, _, last = (pixels(pictures / name) for name in names)
    assert first.shape == (60, 90, 3)
    colorfulness = np.ptp(first, axis=2).max(axis=0)
    assert colorfulness[:45].max() < 0.1  # grey on the left
    assert colorfulness[45:].max() > 0.3  # colours on the right
    assert abs(first - last).max() > 0.1


def test_figure_1_1(tmp_path, resources):
    vertices, faces = noisy_sphere(5)
    source = write_ply(tmp_path / "ball.ply", vertices, faces)
    picture = tmp_path / "figure.png"
    options = ("--mesh", source, "--width", 320, "--samples", 4)
    run(EXAMPLES / "figure_1_1.py", picture, *options, resources=resources)
    seen = pixels(picture)
    assert seen.shape == (128, 320, 3)
    # Four balls of a width of 1 / 4.64 of the picture stand apart by a tenth of that.
    width = 320 / (1.08 * 4.3)
    middles = [round(160 + 1.1 * width * (place - 1.5)) for place in range(4)]
    windows = [seen[49:79, middle - 15 : middle + 15].mean(axis=2) for middle in middles]
    rough = [abs(np.diff(window, axis=1)).mean() for window in windows]
    noisy, adaptive, uniform_once, uniform = rough
    assert noisy > 1.5 * uniform_once > 1.5 * uniform
    assert noisy > 2 * adaptive


def test_every_example_is_tested():
    text = (ROOT / "tests" / "docs" / "test_example_scripts.py").read_text("utf-8")
    for script in EXAMPLES.glob("*.py"):
        assert f"def test_{script.stem}(" in text
