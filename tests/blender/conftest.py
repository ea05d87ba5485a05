"""Tests with Blender as a Python module: every test starts with an empty scene."""

import importlib.util

import pytest

HAS_BPY = importlib.util.find_spec("bpy") is not None
# bpy exists for one Python version per Blender; on others the core is all there is to test.
collect_ignore_glob = [] if HAS_BPY else ["test_*.py"]


@pytest.fixture(autouse=True)
def _empty_scene():
    from adaptive_fairing.blender.files.mesh_files import empty_scene
    from adaptive_fairing.blender.operators import fair

    empty_scene()
    # Its order of the vertices would decide the last bits of what other tests compare.
    fair.preparations.clear()


@pytest.fixture(scope="session")
def addon():
    """Register the add-on for the rest of the session."""
    import adaptive_fairing.blender

    adaptive_fairing.blender.register()
    yield adaptive_fairing.blender
    adaptive_fairing.blender.unregister()


@pytest.fixture
def noisy():
    """Add a selected ball with noise."""
    from support.meshes import noisy_ball
    from support.objects import add_object

    obj = add_object(*noisy_ball(3, 0.02))
    obj.select_set(True)
    return obj


@pytest.fixture(scope="session")
def five_meshes(tmp_path_factory):
    """Give a folder with five small meshes."""
    from support.meshes import random_closed
    from support.objects import write_ply

    folder = tmp_path_factory.mktemp("meshes")
    for seed in range(5):
        write_ply(folder / f"mesh_{seed}.ply", *random_closed(seed))
    return folder


@pytest.fixture(scope="session")
def five_faired(five_meshes, tmp_path_factory):
    """Give a folder with their results, made one by one."""
    from adaptive_fairing.cli import main as cli

    folder = tmp_path_factory.mktemp("one by one")
    for path in five_meshes.iterdir():
        arguments = ["denoise", str(path), "-o", str(folder / path.name), "--quiet"]
        assert cli.main(arguments) == 0
    return folder
