"""Build the extension's packages with Blender's own builder.

One zip for each of Blender's platforms, with scipy wheels for the Pythons of official Blenders,
and one without wheels for Blenders of Linux distributions, which bring their own scipy (listing
binary wheels would make Blender refuse the extension on any other Python).

The sources are copied into a scratch folder first and the manifest is completed there: the
manifest in the repository stays as it is, and nothing that happens to lie in the work tree can
get into a zip.

With --release it makes all of them, and beside them SHA256SUMS and release_notes.md.

Usage: python tools/build_extension.py [--output dist] [--wheels wheels] [--blender PROGRAM]
       [--list] [--release | PACKAGE ...]
"""

from __future__ import annotations

import argparse
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

import release_files
from fetch_wheels import DEFAULT_DIRECTORY, WHEELS, WheelError, fetch_platform

ROOT = Path(__file__).resolve().parent.parent
MANIFEST = "blender_manifest.toml"
CONTENTS = (MANIFEST, "__init__.py", "LICENSE", "adaptive_fairing")
NO_WHEELS = "no-wheels"
WITHOUT_SCIPY = "without_scipy"
"""Word in the name of the zip without wheels, in place of a platform."""

PACKAGES = (NO_WHEELS, *WHEELS)


class BuildError(Exception):
    """Blender's builder is missing, or refused the extension."""


def builder_command(blender: Path | None = None) -> list[str]:
    """Return the command that runs Blender's extension tool.

    Parameters
    ----------
    blender
        A Blender program. Without one, the tool inside this Python's bpy wheel is used; it is a
        stand-alone script and needs no running Blender.

    Raises
    ------
    BuildError
        If there is neither.
    """
    if blender is not None:
        return [str(blender), "--factory-startup", "--command", "extension"]
    found = importlib.util.find_spec("bpy")
    if found is not None and found.origin is not None:
        pattern = "*/scripts/addons_core/bl_pkg/cli/blender_ext.py"
        for script in Path(found.origin).parent.glob(pattern):
            return [sys.executable, str(script)]
    raise BuildError("no extension builder: install bpy, or name a Blender with --blender")


def valid_tags_option(builder: Sequence[str]) -> list[str]:
    """Return the option that makes the stand-alone tool check tags as a real Blender does."""
    script = Path(builder[-1])
    if script.suffix != ".py":
        return []
    scripts = script.parents[3]
    return ["--valid-tags", str(scripts / "modules" / "_bpy_internal" / "extensions" / "tags.py")]


def manifest_with_wheels(manifest: str, platforms: Sequence[str]) -> str:
    """Return the manifest's text completed with ``platforms`` and ``wheels`` of `platforms`.

    The new keys go first: a key after a table's heading would belong to that table.
    """
    wheels = dict.fromkeys(wheel.filename for name in platforms for wheel in WHEELS[name])
    lines = ["platforms = ["]
    lines += [f'    "{name}",' for name in platforms]
    lines += ["]", "wheels = ["]
    lines += [f'    "./wheels/{filename}",' for filename in wheels]
    return "\n".join([*lines, "]", "", manifest])


def build(
    packages: Sequence[str],
    output: Path,
    *,
    wheels: Path = DEFAULT_DIRECTORY,
    blender: Path | None = None,
) -> list[Path]:
    """Build and validate the zips named in `packages`; return their paths, sorted.

    Parameters
    ----------
    packages
        Names out of `PACKAGES`.
    output
        Folder for the zips, made when missing. Zips of the same name are replaced.
    wheels
        Folder of the scipy wheels; missing ones are downloaded into it.
    blender
        See `builder_command`.

    Raises
    ------
    BuildError
        If Blender's tool refuses; the message is the tool's own.
    WheelError
        If a wheel cannot be downloaded or is not the pinned one.
    """
    builder = builder_command(blender)
    output = output.resolve()
    output.mkdir(parents=True, exist_ok=True)
    platforms = [name for name in packages if name != NO_WHEELS]
    built: list[Path] = []
    if NO_WHEELS in packages:
        built += _build_staged(builder, output, [], wheels)
    if platforms:
        built += _build_staged(builder, output, platforms, wheels)
    for path in built:
        _run([*builder, "validate", *valid_tags_option(builder), str(path)])
    return sorted(built)


def listing(archive: Path) -> list[tuple[str, int]]:
    """Return name and unpacked size in bytes of every file in a zip, sorted by name."""
    with zipfile.ZipFile(archive) as opened:
        return sorted((info.filename, info.file_size) for info in opened.infolist())


def _build_staged(
    builder: Sequence[str], output: Path, platforms: Sequence[str], wheels: Path
) -> list[Path]:
    """Build one zip per platform, or the one without wheels if there is none."""
    with tempfile.TemporaryDirectory() as scratch:
        source, made = Path(scratch, "source"), Path(scratch, "made")
        made.mkdir()
        _copy_sources(source)
        command = [*builder, "build", *valid_tags_option(builder)]
        command += ["--source-dir", str(source), "--output-dir", str(made)]
        if platforms:
            (source / "wheels").mkdir()
            for path in {path for name in platforms for path in fetch_platform(name, wheels)}:
                shutil.copy2(path, source / "wheels")
            manifest = source / MANIFEST
            text = manifest_with_wheels(manifest.read_text("utf-8"), platforms)
            manifest.write_text(text, "utf-8")
            command.append("--split-platforms")
        _run(command)
        ending = "" if platforms else f"-{WITHOUT_SCIPY}"
        return [
            Path(shutil.move(path, output / f"{path.stem}{ending}.zip"))
            for path in sorted(made.glob("*.zip"))
        ]


def _copy_sources(destination: Path) -> None:
    destination.mkdir()
    for name in CONTENTS:
        if (ROOT / name).is_dir():
            ignore = shutil.ignore_patterns("__pycache__", ".*")
            shutil.copytree(ROOT / name, destination / name, ignore=ignore)
        else:
            shutil.copy2(ROOT / name, destination)


def _run(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise BuildError(f"{' '.join(command)}\n{done.stdout}{done.stderr}".strip())


def main(arguments: list[str] | None = None) -> int:
    """Build the packages named, or all of them; print sizes and, on request, the contents."""
    parser = argparse.ArgumentParser(description="Build the extension's zips.")
    parser.add_argument("packages", nargs="*", metavar="PACKAGE", help=", ".join(PACKAGES))
    parser.add_argument("--output", type=Path, default=ROOT / "dist")
    parser.add_argument("--wheels", type=Path, default=DEFAULT_DIRECTORY)
    parser.add_argument("--blender", type=Path, help="use this Blender program's builder")
    parser.add_argument("--list", action="store_true", help="print what is inside each zip")
    parser.add_argument(
        "--release",
        action="store_true",
        help="make all packages, their checksums and the release notes",
    )
    options = parser.parse_args(arguments)
    if options.release and options.packages:
        parser.error("--release makes all packages: name none")
    if unknown := set(options.packages) - set(PACKAGES):
        parser.error(f"unknown package {', '.join(sorted(unknown))}; known: {', '.join(PACKAGES)}")
    try:
        built = build(
            options.packages or PACKAGES,
            options.output,
            wheels=options.wheels,
            blender=options.blender,
        )
        extra = release_files.write(built, options.output) if options.release else []
    except (BuildError, WheelError, release_files.ReleaseError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    for path in built:
        entries = listing(path)
        print(f"{path.stat().st_size / 1e6:7.2f} MB  {len(entries):3} files  {path.name}")
        if options.list:
            for name, size in entries:
                print(f"    {size:>11,}  {name}")
    for path in extra:
        print(f"{path.stat().st_size / 1e6:7.2f} MB             {path.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
