"""Contents of an inspected file, and the checks that all formats share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import listed

LARGEST = float(np.finfo(np.float32).max)
"""Largest coordinate in Blender's single precision; a larger one becomes infinite."""

SMALLEST = float(np.finfo(np.float32).tiny / np.finfo(np.float32).eps)
"""Smallest size of a mesh; below it single precision loses digits, or all of them."""

FAR = 32
"""Distance from the origin, in sizes of the mesh, at which five of the 24 binary digits of single
precision are lost."""


class DamagedError(Exception):
    """A file that is damaged or contradicts itself; the message is the reason alone."""


@dataclass(frozen=True)
class Contents:
    """Counts of a mesh file, and corrections for its importer.

    Attributes
    ----------
    n_vertices, n_faces
        Counts in the file; None where they cannot be compared with Blender's mesh.
    n_points
        Number of positions, in a format whose vertices may be split; None for other formats.
    readable
        Corrected content for the importer, if it would misread the file; None if it would not.
    has_faces_before_groups
        Whether an .obj file has groups, and faces before the first of them.
    far
        Coordinates that single precision would round too coarsely; None if there are none.
    """

    n_vertices: int | None = None
    n_faces: int | None = None
    n_points: int | None = None
    readable: bytes | None = None
    has_faces_before_groups: bool = False
    far: FarPoints | None = None


@dataclass(frozen=True)
class FarPoints:
    """Coordinates of a mesh that lies far from the origin.

    Attributes
    ----------
    points
        (n, 3) coordinates in the file.
    parts
        Indices of the points of each mesh that Blender may make, in its order: the whole file, and
        each object in it.
    """

    points: NDArray[np.float64]
    parts: Sequence[NDArray[np.int64]]


def is_far(points: ArrayLike) -> bool:
    """Whether points (n, 3) are `FAR` times as far from the origin as from each other."""
    given = np.asarray(points)
    if len(given) == 0:
        return False
    size = np.ptp(given, axis=0).max() / 2
    return bool(0 < size * FAR < np.abs(given).max())


def require_single_precision(points: ArrayLike) -> None:
    """Refuse points (n, 3) that are not finite in single precision, or all too small for it."""
    size = np.abs(np.asarray(points))
    with np.errstate(invalid="ignore"):
        refuse_not_finite(np.flatnonzero(~(size <= LARGEST).all(axis=1)))
    largest = size.max(initial=0)
    if 0 < largest < SMALLEST:
        raise DamagedError(
            f"its largest coordinate is {largest:.3g}, too small for Blender's single precision: "
            "scale the mesh up"
        )


def refuse_not_finite(vertices: ArrayLike) -> None:
    """Refuse a file if there are any such vertices (k,)."""
    bad = np.asarray(vertices)
    if len(bad):
        raise DamagedError(
            f"{len(bad)} vertices have coordinates that are not finite numbers: {listed(bad)}; "
            "delete or repair them"
        )


def refuse_unknown_vertices(faces: ArrayLike, n_vertices: int) -> None:
    """Refuse a file if there are any such faces (k,), which name vertices that do not exist."""
    bad = np.asarray(faces)
    if len(bad):
        raise DamagedError(
            f"{len(bad)} faces name vertices that are not there: {listed(bad)}; the file has "
            f"{n_vertices} vertices"
        )


def repeated(corners: ArrayLike, starts: ArrayLike) -> NDArray[np.int64]:
    """Find the faces that have the same vertices as an earlier face.

    Parameters
    ----------
    corners
        Vertices of all faces, one face after the other.
    starts
        (m + 1,) start of each face in `corners`, and the end of the last one.

    Returns
    -------
    (k,) array
        Indices of the faces, ascending; neither the order nor the sense of the corners matters.
    """
    corners, starts = np.asarray(corners, dtype=np.int64), np.asarray(starts, dtype=np.int64)
    sizes = np.diff(starts)
    found = [_repeated_of_size(corners, starts, sizes == size, size) for size in _sizes(sizes)]
    return np.sort(np.concatenate(found)) if found else np.empty(0, dtype=np.int64)


def _sizes(sizes: NDArray[np.int64]) -> Iterable[int]:
    return (int(size) for size in np.unique(sizes) if size > 0)


def _repeated_of_size(
    corners: NDArray[np.int64], starts: NDArray[np.int64], chosen: NDArray[np.bool_], size: int
) -> NDArray[np.int64]:
    faces = np.flatnonzero(chosen)
    rows = np.sort(corners[starts[faces, None] + np.arange(size)], axis=1)
    # Stable, so that of equal rows the first in the file comes first.
    order = np.lexsort(rows.T[::-1])
    rows = rows[order]
    equals_former = (rows[1:] == rows[:-1]).all(axis=1)
    return faces[order[1:][equals_former]]
