"""Contents of the zips: the add-on, its licence, its manifest, and the pinned wheels."""

from __future__ import annotations

import hashlib
import subprocess
import tomllib
import zipfile
from pathlib import Path

import pytest

import build_extension
import fetch_wheels

ROOT = Path(__file__).resolve().parents[2]


def expected_files() -> set[str]:
    files = (ROOT / "adaptive_fairing").rglob("*")
    return {"LICENSE", "__init__.py", "blender_manifest.toml"} | {
        path.relative_to(ROOT).as_posix()
        for path in files
        if path.suffix in (".py", ".json", ".typed")
    }


def packaged_files(archive: Path) -> set[str]:
    return {name for name, _ in build_extension.listing(archive)}


@pytest.fixture(scope="module")
def plain_zip(tmp_path_factory) -> Path:
    (built,) = build_extension.build(
        [build_extension.NO_WHEELS], tmp_path_factory.mktemp("plain"), wheels=Path("unused")
    )
    return built


def test_the_zip_without_wheels_holds_the_add_on_and_nothing_else(plain_zip):
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    assert plain_zip.name == f"adaptive_fairing-{manifest['version']}-without_scipy.zip"
    assert packaged_files(plain_zip) == expected_files()
    assert plain_zip.stat().st_size < 600_000


def test_building_the_repository_directly_gives_the_same_files(tmp_path, plain_zip):
    """`blender --command extension build` in a clone: the manifest leaves out the same things."""
    command = [*build_extension.builder_command(), "build"]
    command += ["--source-dir", str(ROOT), "--output-dir", str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    (direct,) = tmp_path.glob("*.zip")
    assert packaged_files(direct) == packaged_files(plain_zip)


def test_building_leaves_the_manifest_in_the_repository_alone(tmp_path):
    before = (ROOT / "blender_manifest.toml").read_bytes()
    build_extension.build([build_extension.NO_WHEELS], tmp_path, wheels=Path("unused"))
    assert (ROOT / "blender_manifest.toml").read_bytes() == before


def test_the_builders_refusal_is_passed_on(tmp_path, monkeypatch):
    monkeypatch.setattr(build_extension, "CONTENTS", ("blender_manifest.toml", "LICENSE"))
    with pytest.raises(build_extension.BuildError, match="__init__"):
        build_extension.build([build_extension.NO_WHEELS], tmp_path, wheels=Path("unused"))


@pytest.mark.thorough
def test_each_platforms_zip_adds_its_pinned_wheels(tmp_path, plain_zip):
    built = build_extension.build(list(fetch_wheels.WHEELS), tmp_path)
    source = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    assert [path.name for path in built] == [
        f"adaptive_fairing-{source['version']}-{platform.replace('-', '_')}.zip"
        for platform in sorted(fetch_wheels.WHEELS)
    ]
    for path, platform in zip(built, sorted(fetch_wheels.WHEELS), strict=True):
        wheels = {f"wheels/{wheel.filename}": wheel for wheel in fetch_wheels.WHEELS[platform]}
        assert packaged_files(path) == packaged_files(plain_zip) | set(wheels)
        with zipfile.ZipFile(path) as archive:
            for name, wheel in wheels.items():
                assert hashlib.sha256(archive.read(name)).hexdigest() == wheel.sha256
            manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        generated = manifest["build"].pop("generated")
        assert generated["platforms"] == [platform]
        assert sorted(generated["wheels"]) == sorted(f"./{name}" for name in wheels)
        assert manifest["version"] == source["version"]
        assert manifest["permissions"] == source["permissions"]
