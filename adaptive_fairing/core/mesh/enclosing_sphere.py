"""The smallest sphere around points."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from ..runtime.arrays import FloatArray

# Points are on the sphere, or inside, if they are so up to this part of its radius.
ROUNDING = 1e-12


def smallest_enclosing_sphere(points: FloatArray) -> tuple[FloatArray, float]:
    """Find the smallest sphere that contains all points.

    That sphere is the smallest one around at most four of the points.  While the current sphere is
    too small, the farthest point joins the set of the next one, whose radius is larger.  So no set
    of four comes up twice, and the search ends at the exact sphere, after about ten passes over the
    points.

    Parameters
    ----------
    points : (n, 3)
        At least one.

    Returns
    -------
    centre : (3,)
    radius : float

    Source: E. Welzl, *Smallest enclosing disks (balls and ellipsoids)*, 1991; B. Gärtner, *Fast and
    robust smallest enclosing balls*, 1999, for taking the farthest point next.
    """
    # Lengths whose squares neither overflow nor underflow.
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = low / 2 + high / 2, float((high - low).max()) or 1.0
    inner = (points - middle) / size
    support = inner[:1]
    centre, radius = inner[0], 0.0
    while True:
        squared = np.einsum("nd,nd->n", inner - centre, inner - centre)
        farthest = inner[np.argmax(squared)]
        if squared.max() ** 0.5 <= radius * (1 + ROUNDING):
            break
        wider_support, wider_centre, wider = _sphere_through(farthest, support)
        if wider <= radius:
            break  # the rest is rounding
        support, centre, radius = wider_support, wider_centre, wider
    return middle + size * centre, size * radius


def _sphere_through(point: FloatArray, support: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Smallest sphere around points, one of which lies on it: points on it, centre, radius."""
    best = np.empty((0, 3)), point, np.inf
    for n_others in range(1, min(len(support), 3) + 1):
        for chosen in combinations(support, n_others):
            # The centre is the point of the others' affine hull at equal distance from all.
            edges = np.array(chosen) - point
            gram = edges @ edges.T
            factors, *_ = np.linalg.lstsq(2 * gram, gram.diagonal(), rcond=None)
            to_centre = factors @ edges
            centre, radius = point + to_centre, float(np.linalg.norm(to_centre))
            reach = np.linalg.norm(support - centre, axis=1).max()
            if reach <= radius * (1 + ROUNDING) and radius < best[2]:
                best = np.vstack([point, *chosen]), centre, radius
    return best
