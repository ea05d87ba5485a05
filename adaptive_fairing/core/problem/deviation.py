"""Bound on the distance of vertices from their input positions."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import FloatArray

Real = TypeVar("Real", np.float32, np.float64)

# Room for the rounding of a distance.
MARGIN = 1 - 8 * np.finfo(np.float64).eps


def limited(
    positions: NDArray[Real], start: FloatArray, limit: float | FloatArray | None
) -> NDArray[Real]:
    """Bring points that are too far from their start back to within the limit.

    Parameters
    ----------
    positions, start : (n, 3)
        The start must be exact in the precision of the positions.
    limit : float or (n,), optional
        Largest distance of all points or of each, in the units of the positions; None for no limit.

    Returns
    -------
    (n, 3)
        No point is farther than `limit` from its start, rounding included.
    """
    if limit is None:
        return positions
    displacement = positions.astype(np.float64) - start
    distance = np.linalg.norm(displacement, axis=1)
    most = np.broadcast_to(limit, distance.shape)
    far = np.flatnonzero(distance > most)
    result = positions.copy()
    result[far] = start[far] + displacement[far] * (most[far] * MARGIN / distance[far])[:, None]
    # Far from the origin sums lose more; one step in each coordinate makes up for it.
    far = far[np.linalg.norm(result[far].astype(np.float64) - start[far], axis=1) > most[far]]
    result[far] = np.nextafter(result[far], start[far].astype(result.dtype))
    return result
