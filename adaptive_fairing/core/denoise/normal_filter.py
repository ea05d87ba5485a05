"""Triangle normals, smoothed within the sides of creases.

A triangle's normal becomes the mean of those around it that turn away from it by less than an
angle, the nearer ones counting for more.  Unlike diffusion in a metric that follows the bending,
this also works between creases that stand only a few edges apart.

Source: X. Sun, P. L. Rosin, R. R. Martin and F. C. Langbein, Fast and effective feature-preserving
mesh denoising, 2007; its weights, on another neighbourhood.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..mesh.normals import unit_vectors
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import FloatArray, IntArray
from ..runtime.threads import ordered_map

TRIANGLES_PER_PIECE = 16384

# Turns by nearly half a circle have no shortest way: 1 + cos of the angle is at least this.
LEAST_OPENING = 0.1


class Smoothing(NamedTuple):
    """How to smooth normals.

    Attributes
    ----------
    angle : float
        In radians, at most π / 2: neighbours that turn further do not count.
    passes : tuple of int
        After how many passes the normals are wanted, ascending.
    """

    angle: float
    passes: tuple[int, ...]


def smoothed_normals(
    normals: FloatArray, around: IntArray, smoothing: Smoothing
) -> Iterator[FloatArray]:
    """Smooth unit normals of triangles.

    Parameters
    ----------
    normals : (m, 3)
    around : (m, k) int
        Triangles around each one, see `triangles_around`.
    smoothing : Smoothing

    Yields
    ------
    (m, 3)
        After each number of passes.
    """
    least = np.cos(smoothing.angle)

    def of_piece(piece: slice) -> FloatArray:
        own, others = normals[piece], normals[around[piece]]
        closeness = np.einsum("fkd,fd->fk", others, own) - least
        weights = np.square(np.maximum(closeness, 0))
        weights[around[piece] < 0] = 0
        mean = np.einsum("fk,fkd->fd", weights, others)
        mean += (1 - least) ** 2 * own
        return unit_vectors(mean)

    starts = range(0, len(normals), TRIANGLES_PER_PIECE)
    pieces = [slice(start, start + TRIANGLES_PER_PIECE) for start in starts]
    for done in range(1, smoothing.passes[-1] + 1):
        normals = np.concatenate(list(ordered_map(of_piece, pieces)))
        if done in smoothing.passes:
            yield normals


def triangles_around(topology: TriangleTopology) -> IntArray:
    """Neighbours of every triangle, and theirs, (m, 12); -1 where there is no other triangle."""
    twin = topology.twin.reshape(-1, 3)
    near = np.where(twin >= 0, twin // 3, -1).astype(np.int32)
    # The last row is that of no triangle.
    beyond = np.append(near, np.full((1, 3), -1, dtype=np.int32), axis=0)[near]
    beyond[beyond == np.arange(len(near))[:, None, None]] = -1
    return np.concatenate([near, beyond.reshape(-1, 9)], axis=1)


def turns_between(before: FloatArray, after: FloatArray) -> FloatArray:
    """Rotations that take unit normals (m, 3) to others by the shortest way, (m, 3, 3).

    The identity for triangles without area, whose normals are 0.
    """
    axis = np.cross(before, after)
    cosine = np.einsum("fd,fd->f", before, after)
    # R = c I + [a]ₓ + a aᵀ / (1 + c).
    share = 1 / np.maximum(1 + cosine, LEAST_OPENING)
    turns: FloatArray = np.einsum("f,fd,fe->fde", share, axis, axis)
    x, y, z = axis.T
    turns += np.stack([cosine, -z, y, z, cosine, -x, -y, x, cosine], axis=1).reshape(-1, 3, 3)
    turns[~before.any(axis=1)] = np.eye(3)
    return turns
