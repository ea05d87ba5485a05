"""The version of the program, whose one place is the manifest of the Blender extension."""

from __future__ import annotations

import tomllib
from importlib import metadata
from pathlib import Path


def program_version() -> str:
    """Version as in ``blender_manifest.toml``.

    The manifest lies beside the package in a source tree and in an installed extension; a package
    installed by pip has copied the version into its own metadata.
    """
    manifest = Path(__file__).resolve().parent.parent / "blender_manifest.toml"
    if manifest.is_file():
        with manifest.open("rb") as file:
            return str(tomllib.load(file)["version"])
    return metadata.version("adaptive-fairing")
