"""Other names for textures in files that only Blender can change: a second export."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy

from ...files.companions import Renames, companions_of
from ...files.errors import FileError


def write_with_other_textures(draft: Path, names: Renames, write: Callable[[], None]) -> None:
    """Export again, with other names for the images.

    Parameters
    ----------
    draft
        Exported file; its textures are beside it, or in folders there.
    names
        Names of the textures, as `names_to_change` returns them.
    write
        Exports to the draft.

    Raises
    ------
    FileError
        A texture kept its old name.
    """
    with tempfile.TemporaryDirectory() as folder:
        for old, new in names.items():
            copy = Path(folder) / Path(new).name
            shutil.copy(draft.parent / old, copy)
            _replace_images(Path(old), bpy.data.images.load(str(copy)))
        for file in companions_of(draft):
            file.unlink()
        draft.unlink()
        write()
    kept = [name for name in names if (draft.parent / name).exists()]
    if kept:
        raise FileError(
            f"cannot write {draft.name}: it needs {kept[0]}, which is another file; choose another "
            "folder"
        )


def _replace_images(file: Path, new: bpy.types.Image) -> None:
    """Use another image in place of those that were exported under this name."""
    for old in bpy.data.images:
        names = bpy.path.basename(old.filepath), old.name, f"{old.name}{file.suffix}"
        if old != new and file.name in names:
            new.colorspace_settings.name = old.colorspace_settings.name
            new.alpha_mode = old.alpha_mode
            old.user_remap(new)
