"""Connected parts of a mesh, whose noise and best filters `auto` judges each by itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csgraph

from .line_roughness import LineRoughness
from .local_frame import LocalFrame
from .noise_level import CLEAN_ROUGHNESS, beyond_clean, noise_level
from .topology import TriangleTopology
from .unbiased_risk import density_classes, least_risk_shares

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Fewer vertices cannot tell noise from shape.
FEWEST_VERTICES = 50
# Connected parts with as many vertices are judged by themselves, smaller ones together.
OWN_ESTIMATE = 400

# A mesh with creases everywhere is clean if along them it is no rougher than clean meshes are, and
# this share of its vertices no rougher than this, in local edge lengths of noise.
SMOOTH_SHARE, CORNER_ROUGHNESS = 0.9, 0.3


class MeshParts:
    """Connected parts that are judged each by itself, small ones together.

    Attributes
    ----------
    is_counted : (n,) bool
        Vertices to judge from.
    """

    def __init__(self, topology: TriangleTopology, frame: LocalFrame, is_still: BoolArray) -> None:
        self.is_counted = ~(is_still | topology.is_loose | topology.on_boundary)
        self._topology, self._frame = topology, frame
        self._size = frame.spread(np.log(frame.spacing), 3)
        _, label = csgraph.connected_components(topology.adjacency(), directed=False)
        n_counted = np.bincount(label, self.is_counted)
        own = n_counted >= OWN_ESTIMATE
        order = np.argsort(label, kind="stable")
        each = np.split(order, np.cumsum(np.bincount(label))[:-1])
        self._members = [each[index] for index in np.flatnonzero(own)]
        rest = [each[index] for index in np.flatnonzero(~own)]
        if rest:
            self._members.append(np.concatenate(rest))

    def noise(self, positions: FloatArray, strength: float) -> tuple[FloatArray, tuple[str, ...]]:
        """Estimate the noise, (n,), and say if there is nothing to do."""
        n_counted = int(np.count_nonzero(self.is_counted))
        noise = np.zeros(len(positions))
        if n_counted < FEWEST_VERTICES:
            return noise, (
                f"only {n_counted} vertices inside the surface: too few to tell noise from shape, "
                "nothing was changed; choose one of the other methods",
            )
        lines = LineRoughness(self._topology, positions, self._frame)
        for members in self._members:
            counted = np.zeros(len(positions), dtype=bool)
            counted[members] = self.is_counted[members]
            level = noise_level(positions, self._frame, counted)
            if beyond_clean(level).any():
                along_lines = lines.level(counted)
                # Creases everywhere look like noise to the level; along them all may be smooth, but
                # for the few places where they meet.  Contoured voxels have more of these.
                is_smooth = along_lines <= CLEAN_ROUGHNESS
                if is_smooth and lines.level(counted, SMOOTH_SHARE) <= CORNER_ROUGHNESS:
                    level = np.minimum(level, along_lines)
            noise += level
        if beyond_clean(strength * noise).any():
            return noise, ()
        return noise, (
            f"no noise found: the surface is rough by {np.median(noise[self.is_counted]):.2g} of "
            "the local edge length, as clean meshes are; nothing was changed",
        )

    def best_shares(
        self, removed: FloatArray, divergence: FloatArray, variance: FloatArray
    ) -> FloatArray:
        """Choose the shares (k, n) of the filters with the least risk in every part."""
        shares = np.zeros_like(removed)
        for members in self._members:
            is_counted = self.is_counted[members]
            if not is_counted.any():
                continue
            counted = members[is_counted]
            classes = density_classes(self._size[members], is_counted)
            chosen = least_risk_shares(
                removed[:, counted],
                divergence[:, counted],
                variance[counted],
                classes[:, is_counted],
            )
            shares[:, members] = chosen.T @ classes
        return shares
