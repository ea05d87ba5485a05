"""Errors of the core: one clear line each, with the culprits attached."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .runtime.arrays import LongArray

MAX_LISTED = 5


class FairingError(Exception):
    """Base of all errors that the core raises on purpose."""


class SettingsError(FairingError):
    """A field of the settings has an invalid value; the message names the field."""


class InputError(FairingError):
    """The arrays are not a mesh: wrong shape or type, numbers not finite or out of range."""


class TopologyError(FairingError):
    """The triangles do not form a surface that the Loop basis is defined on.

    Attributes
    ----------
    vertices : (k,) int array
        Vertices at fault, as indices into the caller's vertex array.
    edges : (e, 2) int array
        Edges at fault, as pairs of vertex indices.
    triangles : (t,) int array
        Triangles at fault.
    """

    def __init__(
        self,
        message: str,
        *,
        vertices: ArrayLike = (),
        edges: ArrayLike = (),
        triangles: ArrayLike = (),
    ) -> None:
        super().__init__(message)
        self.vertices: LongArray = np.asarray(vertices, dtype=np.int64).reshape(-1)
        self.edges: LongArray = np.asarray(edges, dtype=np.int64).reshape(-1, 2)
        self.triangles: LongArray = np.asarray(triangles, dtype=np.int64).reshape(-1)


class SolverError(FairingError):
    """Conjugate gradients cannot solve the linear system of a step."""


def listed(indices: ArrayLike) -> str:
    """Write the first few indices, and how many more there are: ``3, 8, 9, … (17 in all)``."""
    array = np.asarray(indices)
    first = ", ".join(
        str(tuple(int(i) for i in item)) if array.ndim > 1 else str(int(item))
        for item in array[:MAX_LISTED]
    )
    return first if len(array) <= MAX_LISTED else f"{first}, … ({len(array)} in all)"
