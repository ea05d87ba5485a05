"""Connected parts of a mesh, whose noise and best filters `auto` judges each by itself."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csgraph

from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray
from .local_frame import LocalFrame
from .noise.clean_detail import CleanDetail
from .noise.level import CLEAN_ROUGHNESS, beyond_clean, noise_level
from .noise.order_decay import Fading
from .noise.roughness import roughness
from .unbiased_risk import density_classes, least_risk_shares

# Fewer vertices cannot tell noise from shape.
FEWEST_VERTICES = 50
# Connected parts with as many vertices are judged by themselves, smaller ones together.
OWN_ESTIMATE = 400


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

    def noise(
        self, positions: FloatArray, fading: Fading, strength: float
    ) -> tuple[FloatArray, tuple[str, ...]]:
        """Estimate the noise, (n,), and say if there is nothing to do."""
        n_counted = int(np.count_nonzero(self.is_counted))
        noise = np.zeros(len(positions))
        if n_counted < FEWEST_VERTICES:
            return noise, (
                f"only {n_counted} vertices inside the surface: too few to tell noise from shape, "
                "nothing was changed; choose one of the other methods",
            )
        rough = roughness(positions, self._frame)
        detail = CleanDetail(self._topology, positions, self._frame, fading)
        level = np.zeros(len(positions))
        for members in self._members:
            counted = np.zeros(len(positions), dtype=bool)
            counted[members] = self.is_counted[members]
            of_part = noise_level(rough, self._size, counted)
            level += of_part
            noise += detail.without(of_part, counted)
        if beyond_clean(strength * noise).any():
            return noise, ()
        typical = float(np.median(level[self.is_counted]))
        what = "clean meshes are" if typical <= CLEAN_ROUGHNESS else "the detail of clean meshes is"
        return noise, (
            f"no noise found: the surface is rough by {typical:.2g} of the local edge length, as "
            f"{what}; nothing was changed",
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
