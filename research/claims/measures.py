"""Measures of fairness by density class, and timesteps matched to each other.

The paper compares the uniform and the adaptive scheme where "the rough features" are equally
smooth. Here that is a number: the roughness of the coarsest tenth of the vertices.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adaptive_fairing.core import FairingSettings, fair
from tools.geometry.triangles import Faces, FloatArray, edges_of, local_edge_lengths, vertex_normals

MATCH_TOLERANCE = 0.01
"""Relative difference at which two roughnesses count as equal."""

TAU_RANGE = (1e-6, 0.5)


@dataclass(frozen=True)
class Scheme:
    """One of the paper's ways to diffuse."""

    label: str
    method: str
    density: str = "edge_length"

    def settings(self, tau: float, steps: int, **others: object) -> FairingSettings:
        """Return the settings of this scheme for the solver."""
        return FairingSettings(
            method=self.method, density=self.density, tau=tau, steps=steps, **others
        )

    def faired(self, vertices: FloatArray, triangles: Faces, tau: float, steps: int) -> FloatArray:
        """Return the positions (n, 3) after the last step."""
        return fair(vertices, triangles, self.settings(tau, steps)).positions


UNIFORM = Scheme("uniform timestep", "uniform")
TIMESTEP = Scheme("adaptive timestep, edge", "adaptive_timestep")
TIMESTEP_AREA = Scheme("adaptive timestep, area", "adaptive_timestep", "area")
TENSOR = Scheme("adaptive tensor, edge", "adaptive_tensor")
TENSOR_AREA = Scheme("adaptive tensor, area", "adaptive_tensor", "area")
SCHEMES = (UNIFORM, TIMESTEP, TIMESTEP_AREA, TENSOR, TENSOR_AREA)


class DensityClasses:
    """The vertices of a mesh by density, fixed by its clean positions.

    Attributes
    ----------
    lengths
        (n,) mean length of the edges at every vertex.
    coarse, dense
        (n,) whether a vertex is in the coarsest or the densest tenth.
    fifths
        Five such masks, from the coarsest to the densest fifth of the vertices.
    """

    def __init__(self, clean: FloatArray, triangles: Faces) -> None:
        self.triangles = triangles
        self.lengths = local_edge_lengths(clean, triangles)
        self._normals = vertex_normals(clean, triangles)
        low, high = np.percentile(self.lengths, [10, 90])
        self.dense, self.coarse = self.lengths <= low, self.lengths >= high
        rank = np.empty(len(clean), dtype=int)
        rank[np.argsort(-self.lengths, kind="stable")] = np.arange(len(clean))
        self.fifths = [5 * rank // len(clean) == k for k in range(5)]

    def roughness(self, positions: FloatArray, part: NDArray[np.bool_]) -> float:
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

    def distance(
        self, first: FloatArray, second: FloatArray, part: NDArray[np.bool_] | None = None
    ) -> float:
        """Return the RMS distance between two surfaces along the normals, in local edge lengths.

        Only the part along the clean normals counts: vertices may slide within the surface.
        """
        height = self.heights(first, second)
        return float(np.sqrt(np.mean((height if part is None else height[part]) ** 2)))

    def heights(self, first: FloatArray, second: FloatArray) -> FloatArray:
        """Return how far `first` lies over `second` at every vertex, in local edge lengths."""
        return np.einsum("nd,nd->n", first - second, self._normals) / self.lengths

    def by_fifth(self, first: FloatArray, second: FloatArray) -> list[float]:
        """Return the distance in every fifth, from the coarsest to the densest."""
        return [self.distance(first, second, part) for part in self.fifths]


def matched_tau(
    scheme: Scheme, noisy: FloatArray, clean: FloatArray, classes: DensityClasses, steps: int
) -> float:
    """Return the τ at which the coarse parts come out as rough as without noise (bisection)."""
    goal = classes.roughness(clean, classes.coarse)
    low, high = map(math.log, TAU_RANGE)
    for _ in range(30):
        middle = 0.5 * (low + high)
        positions = scheme.faired(noisy, classes.triangles, math.exp(middle), steps)
        reached = classes.roughness(positions, classes.coarse)
        if abs(reached / goal - 1.0) < MATCH_TOLERANCE:
            break
        low, high = (middle, high) if reached > goal else (low, middle)
    return math.exp(middle)


def root_mean_square(values: Iterable[float]) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(np.asarray(list(values))))))
