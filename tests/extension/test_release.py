"""The files beside the zips of a release, and the workflow that publishes them."""

from __future__ import annotations

import hashlib
import re
import struct
import subprocess
import tomllib
from pathlib import Path

import pytest

import build_extension
import release_files

ROOT = Path(__file__).resolve().parents[2]
LISTING = ROOT / "assets" / "listing"
CHANGES = """# Changelog

## [0.10.0] - 2026-02-02

- New.

## [0.1.0] - 2026-01-01

### Added

- First.
"""


def test_notes_are_the_part_of_the_version_alone():
    assert release_files.notes(CHANGES, "0.1.0") == (
        "## [0.1.0] - 2026-01-01\n\n### Added\n\n- First.\n"
    )
    assert release_files.notes(CHANGES, "0.10.0") == "## [0.10.0] - 2026-02-02\n\n- New.\n"


@pytest.mark.parametrize("version", ["0.2.0", "0.1", "0x1.0"])
def test_a_version_without_notes_is_refused(version):
    with pytest.raises(release_files.ReleaseError, match="nothing about"):
        release_files.notes(CHANGES, version)


def test_checksums_are_those_that_sha256sum_checks(tmp_path):
    for name in ("b.zip", "a.zip"):
        (tmp_path / name).write_bytes(name.encode())
    text = release_files.checksums([tmp_path / "b.zip", tmp_path / "a.zip"])
    assert text == "".join(
        f"{hashlib.sha256(name.encode()).hexdigest()}  {name}\n" for name in ("a.zip", "b.zip")
    )


def test_the_changelog_has_notes_for_the_manifests_version(tmp_path):
    written = release_files.write([], tmp_path)
    assert [path.name for path in written] == ["SHA256SUMS", "release_notes.md"]
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    assert f"[{manifest['version']}]" in written[1].read_text("utf-8")


def test_release_takes_no_names_of_packages(capsys):
    with pytest.raises(SystemExit):
        build_extension.main(["--release", "no-wheels"])
    assert "name none" in capsys.readouterr().err


@pytest.mark.thorough
def test_a_release_has_all_zips_and_their_checksums(tmp_path):
    assert build_extension.main(["--release", "--output", str(tmp_path)]) == 0
    zips = sorted(path.name for path in tmp_path.glob("*.zip"))
    assert len(zips) == len(build_extension.PACKAGES)
    lines = (tmp_path / "SHA256SUMS").read_text("utf-8").splitlines()
    assert [line.split("  ")[1] for line in lines] == zips
    subprocess.run(["sha256sum", "--check", "SHA256SUMS"], cwd=tmp_path, check=True)


@pytest.mark.parametrize(
    ("name", "size"),
    [("icon", (256, 256)), ("featured", (1920, 1080))]
    + [(f"preview_{number}", (1920, 1080)) for number in range(1, 6)],
)
def test_a_picture_of_the_listing_has_the_size_that_the_platform_wants(name, size):
    data = (LISTING / f"{name}.png").read_bytes()
    assert data.startswith(b"\x89PNG")
    assert struct.unpack(">II", data[16:24]) == size


def test_the_workflow_makes_the_release_by_the_documented_command():
    workflow = (ROOT / ".github" / "workflows" / "release.yml").read_text("utf-8")
    commands = re.findall(r"- run: (.*)", workflow)
    assert "python tools/build_extension.py --release" in commands
    pages = (ROOT / "docs" / "releasing.md").read_text("utf-8")
    assert "python tools/build_extension.py --release" in pages
