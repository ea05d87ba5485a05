"""The installed extension in the real program without a window: scripts and the command line."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.app

KEYS = ["Basis", "Fairing 1", "Fairing 2", "Fairing 3", "Fairing 4"]
NOISE = 0.01  # standard deviation of each coordinate in inside/background.py


@pytest.fixture(scope="module")
def script(app) -> dict:
    folder = app.directory / "background"
    folder.mkdir(exist_ok=True)
    return {**app.script("fair", folder), "folder": folder}


def test_the_operator_blocks_in_a_script_and_gives_the_cores_result(script):
    assert script["status"] == ["FINISHED"]
    assert script["keys"] == KEYS
    assert script["equal to core"]


@pytest.fixture(scope="module")
def command(app, script) -> dict:
    folder = script["folder"]
    output = folder / "command.blend"
    arguments = ["fair", folder / "noisy.obj", "-o", output, "--no-denoised"]
    assert app.blender(["-c", "adaptive_fairing", *arguments]) == 0
    return app.script("inspect", output, folder)


def test_the_command_makes_an_animated_file(command):
    assert command["keys"] == KEYS
    assert command["absolute"]
    assert command["animated"]
    assert command["attributes"] == ["fairing_density", "fairing_density_color"]
    roughness = [command["roughness"][name] for name in KEYS]
    assert roughness[0] == pytest.approx(NOISE, rel=0.05)
    assert roughness == sorted(roughness, reverse=True)
    assert roughness[-1] < 0.6 * NOISE


def test_the_command_and_the_operator_agree(app, script, command):
    """The command's mesh comes from a text file: equal to the digits that an .obj holds."""
    folder = script["folder"]
    by_operator = app.script("inspect", folder / "script.blend", folder)
    assert command["roughness"] == pytest.approx(by_operator["roughness"], rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [(["fair", "missing.obj"], 1), (["fair", "noisy.obj", "--steps", "0"], 2), ([], 2)],
)
def test_the_commands_exit_code_says_what_is_wrong(app, script, arguments, code):
    paths = [str(script["folder"] / each) if each.endswith(".obj") else each for each in arguments]
    assert app.blender(["-c", "adaptive_fairing", *paths]) == code
