"""Inspection of a mesh file before Blender's importer, without Blender.

The importers trust what a file says of itself. With a wrong count or a truncated file they crash;
they drop a face whose vertex does not exist, and turn a coordinate that is not a number into 0.
Here such files are refused, with the number of culprits and the first of them. That costs one pass
over the file with numpy, little beside a solve.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path

from ..errors import FileError
from ..formats import suffix_of
from .contents import Contents, DamagedError
from .fbx import inspect_fbx
from .gltf import inspect_gltf
from .obj import inspect_obj
from .ply import inspect_ply
from .stl import inspect_stl
from .usd import inspect_usd

_INSPECTORS: Mapping[str, Callable[[Path], Contents]] = {
    ".obj": inspect_obj,
    ".ply": inspect_ply,
    ".stl": inspect_stl,
    ".glb": inspect_gltf,
    ".gltf": inspect_gltf,
    ".fbx": inspect_fbx,
    ".usd": inspect_usd,
    ".usda": inspect_usd,
    ".usdc": inspect_usd,
    ".usdz": inspect_usd,
}


def inspect(path: Path) -> Contents:
    """Count what a file holds, and refuse one that its importer would misread.

    Parameters
    ----------
    path
        An existing file. For formats without a reader here the counts are None.

    Raises
    ------
    FileError
        The file is cut short or contradicts itself, coordinates are not finite numbers in single
        precision, or faces name vertices that do not exist.
    OSError
        The file cannot be read.
    """
    if suffix_of(path) not in _INSPECTORS:
        return Contents()
    status = path.stat()
    return _inspect(path, status.st_size, status.st_mtime_ns)


# A file is asked for twice: before its import, and after it to count what was left out.
@lru_cache(maxsize=1)
def _inspect(path: Path, size: int, modified_ns: int) -> Contents:
    try:
        return _INSPECTORS[suffix_of(path)](path)
    except DamagedError as error:
        raise FileError(f"cannot read {path}: {error}") from error
