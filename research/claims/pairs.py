"""Pairs of a noisy and a clean mesh with the same triangles: the samples, or files."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from adaptive_fairing.core import FairingError
from tools.geometry.ply import read_ply
from tools.geometry.triangles import Faces, FloatArray

from .measures import DensityClasses

ASSETS = Path(__file__).resolve().parents[2] / "assets"


@dataclass(frozen=True)
class PublishedRun:
    """The paper's settings for one of its figures: a uniform and an adaptive τ, and the steps."""

    uniform: float
    adaptive: float
    steps: int

    def tau(self, method: str) -> float:
        """Return the paper's τ for a method."""
        return self.uniform if method == "uniform" else self.adaptive


HEAD = PublishedRun(0.001, 0.016, 4)
"""Fig 1.1; also used for meshes that the paper has no figure of."""

PUBLISHED = {
    "head": HEAD,
    "foot": PublishedRun(0.0011, 0.025, 3),  # Fig 4.1
    "crocodile": PublishedRun(0.0001, 0.0016, 4),  # Fig 4.2
}


@dataclass(frozen=True)
class MeshPair:
    """One shape with and without noise.

    Attributes
    ----------
    name
        For titles.
    noisy, clean
        (n, 3) positions.
    triangles
        (m, 3) vertex indices, the same for both.
    published
        The paper's settings for such a mesh.
    """

    name: str
    noisy: FloatArray
    clean: FloatArray
    triangles: Faces
    published: PublishedRun = HEAD

    @cached_property
    def classes(self) -> DensityClasses:
        """The vertices by density."""
        return DensityClasses(self.clean, self.triangles)


def sample_pair(name: str) -> MeshPair:
    """Return one of the committed samples: head, foot or crocodile."""
    clean, triangles = read_ply(ASSETS / f"{name}.ply")
    noisy, _ = read_ply(ASSETS / f"{name}_noisy.ply")
    return MeshPair(name, noisy, clean, triangles, PUBLISHED[name])


def file_pair(noisy: Path, clean: Path) -> MeshPair:
    """Read a pair of mesh files in any format that Blender imports.

    Raises
    ------
    FairingError
        A file cannot be read, or the two do not have the same triangles and vertices.
    """
    # Blender is needed for other people's files only: the samples have their own reader.
    from adaptive_fairing.blender.data.mesh_arrays import read_mesh
    from adaptive_fairing.blender.files.mesh_files import import_mesh

    meshes = [read_mesh(import_mesh(path, keep_axes=True).data) for path in (noisy, clean)]
    first, second = meshes
    if first.vertices.shape != second.vertices.shape or not np.array_equal(
        first.triangles, second.triangles
    ):
        raise FairingError(
            f"{noisy.name} and {clean.name} are no pair: they need the same vertices and "
            "triangles in the same order"
        )
    return MeshPair(noisy.stem, first.vertices, second.vertices, first.triangles)
