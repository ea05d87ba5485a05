"""Smoothing of triangle normals within the sides of creases.

A triangle's normal becomes the mean of the normals around it that differ from it by less than an
angle; similar normals count for more.  Unlike diffusion in a metric that follows the bending, this
also works between creases only a few edges apart.

Noise of one amplitude turns small triangles further than large ones, so their normals count for
less.

Source: X. Sun, P. L. Rosin, R. R. Martin and F. C. Langbein, Fast and effective feature-preserving
mesh denoising, 2007; its weights, on another neighbourhood.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..mesh.normals import dots, unit_vectors
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import FloatArray, IntArray, RealArray
from ..runtime.threads import chunks, ordered_map
from .lifted_metric import area_elements, edge_vectors, half_cotangents
from .parameters import parameters
from .triangle_surface import TriangleSurface

TRIANGLES_PER_CHUNK = 32768

# Relative: for noise that varies by less, weights are not worth their time.
LEAST_RANGE = 0.01

# 1 + cos of the angle of a turn is at least this: half a turn has no shortest way.  With a tenth of
# it nothing changes.
LEAST_OPENING = 0.1


class Smoothing(NamedTuple):
    """Parameters of the smoothing of normals.

    Attributes
    ----------
    angle : float
        Angle in radians, at most π / 2; normals that differ by more do not count.
    passes : tuple of int
        Numbers of passes after which the normals are wanted, ascending.
    """

    angle: float
    passes: tuple[int, ...]


def smoothed_normals(
    normals: FloatArray,
    around: IntArray,
    smoothing: Smoothing,
    weights: FloatArray | None = None,
) -> Iterator[FloatArray]:
    """Smooth unit normals of triangles, in single precision.

    Parameters
    ----------
    normals : (m, 3)
    around : (k, m) int
        Triangles around each one, see `triangles_around`.
    smoothing : Smoothing
    weights : (m,), optional
        Weight of each triangle, see `weights_of_normals`; by default all are equal.

    Yields
    ------
    (m, 3)
        Normals after each number of passes.
    """
    least = np.float32(np.cos(smoothing.angle))
    n = len(normals)
    # The last one is that of no triangle: its weight is 0, for `least` is not negative.
    columns = np.zeros((3, n + 1), dtype=np.float32)
    columns[:, :n] = normals.T
    trust = None if weights is None else np.append(weights, 0).astype(np.float32)

    def of_chunk(chunk: slice) -> RealArray:
        own = columns[:, chunk]
        mean = (1 - least) ** 2 * own
        if trust is not None:
            mean *= trust[chunk]
        for neighbours in around[:, chunk]:
            # All indices are in range, and mode "wrap" saves the time of checking them.
            other = columns.take(neighbours, axis=1, mode="wrap")
            weight = np.einsum("df,df->f", other, own)
            weight -= least
            np.maximum(weight, 0, out=weight)
            weight *= weight
            if trust is not None:
                weight *= trust.take(neighbours, mode="wrap")
            other *= weight
            mean += other
        length = np.sqrt(np.einsum("df,df->f", mean, mean))
        mean /= np.where(length > 0, length, 1)
        return mean

    parts = chunks(n, TRIANGLES_PER_CHUNK)
    for done in range(1, smoothing.passes[-1] + 1):
        following = np.zeros_like(columns)
        for chunk, smooth in zip(parts, ordered_map(of_chunk, parts), strict=True):
            following[:, chunk] = smooth
        columns = following
        if done in smoothing.passes:
            yield columns[:, :n].T.astype(np.float64)


def weights_of_normals(topology: TriangleTopology, noise: FloatArray) -> FloatArray | None:
    """Weights (m,) of the normals of triangles; None if all are equal.

    Noise of σ local edge lengths turns a normal by about σ.  A weight is the inverse of that
    variance plus the square of `coarse_noise`, because less noise does not matter.

    Parameters
    ----------
    topology : TriangleTopology
    noise : (n,)
        Standard deviation in local edge lengths; 0 where it is not known.
    """
    known = noise[noise > 0]
    if not len(known) or np.ptp(known) <= LEAST_RANGE * known[0]:
        return None
    corners = noise[topology.triangles]
    variance = np.square(corners).sum(axis=1) / np.maximum(np.count_nonzero(corners, axis=1), 1)
    variance[variance == 0] = np.median(np.square(known))
    return 1 / (variance + parameters().coarse_noise ** 2)


def triangles_around(topology: TriangleTopology) -> IntArray:
    """Neighbours of every triangle, and theirs, (9, m); m where there is no other triangle."""
    m = topology.n_triangles
    # Half-edges on the other side; the last row stands for those of no triangle.
    twin = np.append(topology.twin, [-1, -1, -1]).astype(np.intp)
    near = np.where(twin >= 0, twin // 3, m).reshape(-1, 3)
    entry = np.where(twin >= 0, twin % 3, 0).reshape(-1, 3)[:m]
    ways = [near[:m]]
    for turn in (1, 2):
        ways.append(near[near[:m], (entry + turn) % 3])
    return np.ascontiguousarray(np.concatenate(ways, axis=1).T, dtype=np.int32)


class TurningLoads:
    """Right sides of the fits to normals: the effect of turned triangles on a surface.

    Parameters
    ----------
    surface : TriangleSurface

    Attributes
    ----------
    normals : (m, 3)
        Unit normals of the triangles.
    """

    def __init__(self, surface: TriangleSurface) -> None:
        triangles, positions = surface.topology.triangles, surface.positions
        self._n_vertices = len(positions)
        self._corners = triangles.T.reshape(-1).astype(np.intp)  # once, not for every sum
        self.normals = unit_vectors(surface.triangle_normals())
        # From corner k to the next: (3 coordinates, 3 corners, m).
        self._pulls = edge_vectors(triangles, np.ascontiguousarray(positions.T))
        x, y, z = self._pulls
        squares = x * x + y * y + z * z
        self._pulls *= half_cotangents(squares, area_elements(squares))

    def of(self, turned: FloatArray) -> FloatArray:
        """Integrate (∇x - R ∇x) · ∇φ_a over the surface with turns R of its triangles, (n, 3).

        Parameters
        ----------
        turned : (m, 3)
            Unit normals of the triangles after the turns, which take the shortest way.

        Source: the right side of Y. Yu et al., Mesh editing with Poisson-based gradient field
        manipulation, 2004, for linear elements.
        """
        # A turn from n to n' takes a tangent v to v - (n' · v) (n + n') / (1 + n · n').
        opening = 1 + dots(self.normals, turned)
        middle = (self.normals + turned) / np.maximum(opening, LEAST_OPENING)[:, None]
        change = np.einsum("dkf,fd->kf", self._pulls, turned)
        # Of edge k at its ends: what flows into corner k is what comes along edge k - 1 less
        # edge k.
        flow = np.roll(change, 1, axis=0)
        flow -= change
        del change  # among the largest arrays
        sums = [
            np.bincount(self._corners, (flow * m).reshape(-1), self._n_vertices) for m in middle.T
        ]
        return np.stack(sums, axis=1)
