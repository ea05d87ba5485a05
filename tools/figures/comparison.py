"""How far a surface is faired: roughness by density, and timesteps matched to each other.

The paper compares the uniform and the adaptive scheme where "the rough features" are equally
smooth. Here that is a number: the roughness of the coarsest tenth of the vertices.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from adaptive_fairing.core import FairingSettings, fair
from samples.adaptive import edges_of, mean_edge_lengths, vertex_normals

Array = NDArray[np.float64]

MATCH_TOLERANCE = 0.01
"""Relative difference at which two roughnesses count as equal."""


class DensityClasses:
    """The coarsest and the densest tenth of a mesh's vertices, fixed by its input."""

    def __init__(self, vertices: Array, triangles: NDArray[np.int32]) -> None:
        self.triangles = triangles
        self.lengths = mean_edge_lengths(vertices, triangles)
        low, high = np.percentile(self.lengths, [10, 90])
        self.dense, self.coarse = self.lengths <= low, self.lengths >= high

    def roughness(self, positions: Array, part: NDArray[np.bool_]) -> float:
        """Return the RMS height of a vertex over its neighbours' mean, in local edge lengths."""
        edges = edges_of(self.triangles)
        both = np.concatenate([edges, edges[:, ::-1]])
        total = np.zeros_like(positions)
        np.add.at(total, both[:, 0], positions[both[:, 1]])
        valence = np.bincount(both[:, 0], minlength=len(positions))
        offset = positions - total / valence[:, None]
        normal = vertex_normals(positions, self.triangles)
        height = np.einsum("nd,nd->n", offset, normal) / self.lengths
        return float(np.sqrt(np.mean(height[part] ** 2)))

    def error(self, positions: Array, clean: Array, part: NDArray[np.bool_]) -> float:
        """Return the RMS distance to the clean positions, in local edge lengths.

        Only the part along the clean normals counts: vertices may slide within the surface.
        """
        normal = vertex_normals(clean, self.triangles)
        height = np.einsum("nd,nd->n", positions - clean, normal) / self.lengths
        return float(np.sqrt(np.mean(height[part] ** 2)))


def faired(
    vertices: Array,
    triangles: NDArray[np.int32],
    method: str,
    tau: float,
    steps: int,
    density: str = "edge_length",
) -> list[Array]:
    """Return the positions after every step."""
    settings = FairingSettings(method=method, tau=tau, steps=steps, density=density)
    return [step.positions for step in fair(vertices, triangles, settings).steps]


def matched_tau(
    vertices: Array,
    triangles: NDArray[np.int32],
    method: str,
    steps: int,
    part: NDArray[np.bool_],
    goal: float,
    classes: DensityClasses,
) -> float:
    """Return the τ at which `part` is as rough as `goal` after `steps` steps (bisection)."""
    low, high = math.log(1e-6), math.log(0.5)
    for _ in range(30):
        middle = 0.5 * (low + high)
        positions = faired(vertices, triangles, method, math.exp(middle), steps)[-1]
        reached = classes.roughness(positions, part)
        if abs(reached / goal - 1.0) < MATCH_TOLERANCE:
            break
        low, high = (middle, high) if reached > goal else (low, middle)
    return math.exp(middle)
