"""Edges that were laid out for the shape, as those of decimated and modelled meshes are.

Whoever makes a mesh for a shape lays its edges along the bends, and so does decimation.  Most edges
then leave the surface smoother than the other diagonal of their two triangles would.  And edges are
long where the surface bends little across them.  Noise that came later does not know the edges: it
only prefers the shorter diagonal, and bends short edges more, as any other noise on the same mesh.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import rankdata

from ...mesh.normals import dots, triangle_normals, unit_vectors
from ...mesh.topology import following
from ...runtime.arrays import BoolArray, FloatArray, IntArray
from ..triangle_surface import TriangleSurface
from .noisy_surface import NoisySurface

# So many edges tell the mean to 0.005; to compare all of a large mesh takes seconds.
MOST_EDGES = 50_000


def laid_excess(
    surface: NoisySurface, level: FloatArray, is_counted: BoolArray
) -> tuple[float, float]:
    """Measure how much more the edges follow the bends than if noise had come later.

    Parameters
    ----------
    surface : NoisySurface
    level : (n,)
        Standard deviation of the noise to compare with, in local edge lengths.
    is_counted : (n,) bool
        Vertices whose edges are judged.

    Returns
    -------
    better : float
        Edges that are better than the other diagonal, less those that are worse, over all edges;
        minus the same of white noise on the slightly smoothed surface. Between -2 and 2.
    evened : float
        How much less longer edges bend, as a correlation; minus the same of that noise.
    """
    positions, frame = surface.positions, surface.frame
    # Only the heights are replaced: along the surface the vertices stay.
    smooth = positions + frame.raised(frame.along_normal(frame.positions - positions))
    of_noise = [
        _laid(smooth + frame.raised(level * each), frame, is_counted)
        for each in surface.own.several()
    ]
    better, evened = _laid(positions, frame, is_counted) - np.mean(of_noise, axis=0)
    return float(better), float(evened)


def _laid(positions: FloatArray, frame: TriangleSurface, is_counted: BoolArray) -> FloatArray:
    """Compare edges with the other diagonals, and their lengths with their bends, both -1 to 1.

    Sources: angles between normals, N. Dyn, D. Levin, S. Rippa, Data dependent triangulations for
    piecewise linear interpolation, 1990; correlation of ranks, C. Spearman, The proof and
    measurement of association between two things, 1904.
    """
    topology = frame.topology
    normals = unit_vectors(triangle_normals(positions, topology.triangles))
    corners, twin, side = topology.origins, topology.twin, topology.inner_edges
    side = side[is_counted[corners[side]]]
    side = side[:: 1 + len(side) // MOST_EDGES]
    other = twin[side]
    rims = [following(each, step) for each in (side, other) for step in (1, 2)]
    ends = start, end, apex, beyond = [corners[each] for each in (side, *rims[:2], rims[3])]
    across = [twin[each] for each in rims]
    beside = [normals[each // 3] for each in across]

    def unit_normals(first: IntArray, second: IntArray, third: IntArray) -> FloatArray:
        origin = positions[first]
        return unit_vectors(np.cross(positions[second] - origin, positions[third] - origin))

    def smoothness(first: FloatArray, second: FloatArray, at_rims: list[FloatArray]) -> FloatArray:
        """Sum of the cosines of the angles at the edge and at the four around."""
        cosines: FloatArray = dots(first, second) + sum(map(dots, at_rims, beside))
        return cosines

    here, there = normals[side // 3], normals[other // 3]
    at_start, at_end = unit_normals(start, beyond, apex), unit_normals(end, apex, beyond)
    better = np.sign(
        smoothness(here, there, [here, here, there, there])
        - smoothness(at_start, at_end, [at_end, at_start, at_start, at_end])
    )
    # The other diagonal of four corners that are not convex folds the surface.
    is_convex = np.all([dots(each, here + there) > 0 for each in (at_start, at_end)], axis=0)
    is_inside = np.all([is_counted[each] for each in ends], axis=0)
    is_judged = is_convex & is_inside & np.all([each >= 0 for each in across], axis=0)
    if not is_judged.any():
        return np.zeros(2)
    bends = 1 - dots(here, there)
    lengths = np.linalg.norm(positions[end] - positions[start], axis=1)
    lengths /= np.sqrt(frame.spacing[start] * frame.spacing[end])
    ranks = np.stack([rankdata(each[is_judged]) for each in (lengths, bends)])
    ranks -= ranks.mean(axis=1, keepdims=True)
    # Equal edges tell nothing.
    scale = max(float(np.linalg.norm(ranks, axis=1).prod()), 1.0)
    return np.array([better[is_judged].mean(), -ranks[0] @ ranks[1] / scale])
