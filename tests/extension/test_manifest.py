"""The manifest, the pinned wheels and the version agree with each other and with Blender's tool."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

import build_extension
import fetch_wheels
from adaptive_fairing.version import program_version

ROOT = Path(__file__).resolve().parents[2]
MANIFEST_TEXT = (ROOT / "blender_manifest.toml").read_text("utf-8")
MANIFEST = tomllib.loads(MANIFEST_TEXT)
# Blender's platform names in terms of the last part of a wheel's platform tag.
WHEEL_SUFFIX = {
    "linux-x64": "_x86_64",
    "windows-x64": "win_amd64",
    "windows-arm64": "win_arm64",
    "macos-arm64": "_arm64",
    "macos-x64": "_x86_64",
}
WHEEL_PREFIX = {"linux": "manylinux", "windows": "win", "macos": "macosx"}


@pytest.mark.parametrize("broken", [None, ("Sculpt", "Sculpture"), ("details kept", "kept.")])
def test_blenders_own_tool_accepts_the_manifest_and_its_tags(tmp_path, broken):
    """Two broken copies show that the tool really looks at the tags and at the tagline."""
    text = MANIFEST_TEXT if broken is None else MANIFEST_TEXT.replace(*broken)
    assert broken is None or text != MANIFEST_TEXT
    (tmp_path / "blender_manifest.toml").write_text(text, "utf-8")
    (tmp_path / "__init__.py").write_bytes((ROOT / "__init__.py").read_bytes())
    builder = build_extension.builder_command()
    command = [*builder, "validate", *build_extension.valid_tags_option(builder), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode == 0) == (broken is None), done.stdout + done.stderr


def test_manifest_has_what_the_extensions_platform_asks_for():
    assert MANIFEST["license"] == ["SPDX:GPL-3.0-or-later"]
    assert "GNU GENERAL PUBLIC LICENSE" in (ROOT / "LICENSE").read_text("utf-8")[:200]
    assert MANIFEST["id"] == "adaptive_fairing"
    assert MANIFEST["blender_version_min"] == "4.2.0"
    assert set(MANIFEST["permissions"]) == {"files"}, "the add-on touches nothing but files"
    assert "Blender" not in MANIFEST["name"], "reserved by the platform's terms"
    for key in ("tagline", "website", "tags", "copyright", "maintainer"):
        assert MANIFEST[key]


def test_version_has_one_place():
    assert program_version() == MANIFEST["version"]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    assert project["project"]["dynamic"] == ["version"]
    source = project["tool"]["hatch"]["version"]
    assert source["path"] == "blender_manifest.toml"
    assert re.search(source["pattern"], MANIFEST_TEXT)["version"] == MANIFEST["version"]
    heading = re.search(r"^## \[(\d[^\]]*)\]", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)
    assert heading[1] == MANIFEST["version"], "the newest entry of the changelog"


@pytest.mark.parametrize("platform", fetch_wheels.WHEELS)
def test_every_platform_pins_one_wheel_for_each_python(platform):
    wheels = fetch_wheels.WHEELS[platform]
    assert sorted(wheel.abi for wheel in wheels) == ["cp311", "cp313"]
    for wheel in wheels:
        assert wheel.requirement.startswith("scipy==1.")
        assert re.fullmatch(r"[0-9a-f]{64}", wheel.sha256)
        for tag in wheel.platform_tags:
            assert tag.startswith(WHEEL_PREFIX[platform.partition("-")[0]])
            assert tag.endswith(WHEEL_SUFFIX[platform])


def test_completed_manifest_differs_in_platforms_and_wheels_alone():
    completed = tomllib.loads(
        build_extension.manifest_with_wheels(MANIFEST_TEXT, list(fetch_wheels.WHEELS))
    )
    names = [wheel.filename for wheels in fetch_wheels.WHEELS.values() for wheel in wheels]
    assert completed.pop("platforms") == list(fetch_wheels.WHEELS)
    assert completed.pop("wheels") == [f"./wheels/{name}" for name in names]
    assert completed == MANIFEST


def test_a_wheel_that_is_not_the_pinned_one_is_refused(tmp_path):
    wheel = fetch_wheels.WHEELS["linux-x64"][0]
    (tmp_path / wheel.filename).write_bytes(b"something else")
    with pytest.raises(fetch_wheels.WheelError, match="SHA-256"):
        fetch_wheels.fetch(wheel, tmp_path)


def test_ci_runs_the_readmes_test_command_word_for_word():
    command = 'pip install ".[test]" && python -m pytest'
    readme = (ROOT / "README.md").read_text("utf-8")
    assert command in re.findall(r"^```sh\n(.*?)\n```$", readme, re.M | re.S)
    lines = (ROOT / ".ci" / "run").read_text("utf-8").splitlines()
    assert command in [line.strip() for line in lines]
