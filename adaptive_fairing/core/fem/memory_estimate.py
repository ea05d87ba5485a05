"""Memory that a solve needs, estimated before it starts."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..errors import FairingError
from ..loop.basis import table_depth
from ..loop.fitted_quadrature import POINTS, is_fitted
from ..loop.partition import triangle_slabs
from ..loop.patch_class import PatchClass, is_regular_patch
from ..loop.patches import PatchSet
from ..loop.quadrature import QuadratureChoice
from ..runtime.arrays import LongArray
from ..runtime.system_memory import available_bytes
from ..runtime.threads import n_threads
from .patch_tables import product_table_pays
from .table_cache import FEW_TRIANGLES, LARGEST_RARE

Algorithm = Literal["fair", "denoise"]

# Bytes, fitted to the measured peak of runs on regular, irregular, cut and pole meshes of 200 to
# 1,000,000 triangles (benchmarks.memory prints estimate and measurement side by side).
FIXED_BYTES = 50_000_000
FAIR_BYTES_PER_TRIANGLE = 650  # topology, patches, sparsity pattern, matrix, solver's vectors
BYTES_PER_LOCAL_ENTRY = 4  # place in the matrix of an entry of a triangle's local matrix
BYTES_PER_ENTRY_IN_WORK = 16  # the same while its chunk is assembled, and places are looked up
BYTES_PER_TABLE_NUMBER = 16  # basis functions at quadrature points: in the table and its parts
DENOISE_BYTES_PER_TRIANGLE = 2000  # all but the tables: what the filters remove, mostly

# Neighbours beyond which a vertex is worth naming: its memory grows with their cube.
NOTABLE_VALENCE = 300


class MemoryNeededError(FairingError):
    """The solve needs more memory than there is.

    Attributes
    ----------
    needed, available : int
        Bytes.
    """

    def __init__(self, message: str, needed: int, available: int) -> None:
        super().__init__(message)
        self.needed = needed
        self.available = available


def require_memory(
    patches: PatchSet, quadrature_tolerance: float, algorithm: Algorithm = "fair"
) -> None:
    """Refuse a mesh whose solve does not fit into memory.

    Raises
    ------
    MemoryNeededError
        The message has the numbers.  Nothing is raised if the system does not report its memory.
    """
    available = available_bytes()
    if available is None:
        return
    needed = estimated_bytes(patches, quadrature_tolerance, algorithm)
    if needed <= available:
        return
    topology = patches.topology
    poles = np.flatnonzero(topology.ring_size > NOTABLE_VALENCE)
    advice = "decimate it, or fair it in parts"
    if len(poles):
        advice = f"{len(poles)} vertices have more than {NOTABLE_VALENCE} neighbours, remesh there"
    raise MemoryNeededError(
        f"a mesh of {topology.n_triangles} triangles needs about {needed / 1e9:.1f} GB of memory, "
        f"{available / 1e9:.1f} GB are available: {advice}",
        needed,
        available,
    )


def estimated_bytes(
    patches: PatchSet, quadrature_tolerance: float, algorithm: Algorithm = "fair"
) -> int:
    """Estimate the peak memory of a solve: an upper bound.

    `fair` uses at least about half of it, `denoise` two thirds where the mesh is large.

    Parameters
    ----------
    patches : PatchSet
        Of the mesh that is solved on.
    quadrature_tolerance : float
        Decides the size of the tables.
    algorithm : "fair" or "denoise"
        The second only evaluates the Loop basis, and assembles nothing in it.
    """
    n_triangles = patches.topology.n_triangles
    choice = patches.quadrature(quadrature_tolerance)
    n_control = patches.n_control_points.astype(np.int64)
    n_pairs = n_control * (n_control + 1) // 2
    n_points = np.array([_n_points(each, choice) for each in patches.classes], dtype=np.int64)
    tables = 8 * BYTES_PER_TABLE_NUMBER * n_points * n_control
    rare = _rare_bytes(n_points * n_control, patches)
    evaluation = int(FIXED_BYTES + tables.sum() + rare.sum())
    if algorithm == "denoise":
        return evaluation + DENOISE_BYTES_PER_TRIANGLE * n_triangles

    local = n_pairs[patches.class_of]
    slab_sizes = [int(local[slab].sum()) for slab in triangle_slabs(n_triangles)]
    in_work = min(sum(slab_sizes), 2 * n_threads() * max(slab_sizes))
    n_products = 4 * n_points * n_pairs
    of_class = zip(n_products, patches.class_sizes, strict=True)
    products = 8 * n_products[[product_table_pays(*each) for each in of_class]]
    return int(
        evaluation
        + FAIR_BYTES_PER_TRIANGLE * n_triangles
        + BYTES_PER_LOCAL_ENTRY * local.sum()
        + BYTES_PER_ENTRY_IN_WORK * in_work
        + products.sum()
    )


def _rare_bytes(n_numbers: LongArray, patches: PatchSet) -> LongArray:
    """Bound the tables of rare classes, each with n_points * n_control_points `n_numbers`."""
    n_triangles = patches.topology.n_triangles
    n_slabs = len(triangle_slabs(n_triangles))
    n_rare = np.minimum(patches.class_sizes, FEW_TRIANGLES * n_slabs)
    bound: LongArray = np.where(6 * n_numbers <= LARGEST_RARE, 8 * 6 * n_numbers * n_rare, 0)
    return bound


def _n_points(patch_class: PatchClass, choice: QuadratureChoice) -> int:
    """Bound the number of quadrature points: all three corners refined to the choice's depth."""
    if is_regular_patch(patch_class):
        return len(choice.regular.weights)
    if choice.prefers_fitted and is_fitted(patch_class):
        return len(POINTS)
    return len(choice.irregular.weights) * max(9 * table_depth(patch_class, choice) - 5, 1)
