"""Partition of the triangles into those that are integrated together.

The mesh is cut into slabs: triangles that follow each other in the order of the solve, which goes
along the longest axis.  A chunk has the triangles of one slab, but for those of uncommon classes:
they wait in chunks of their own for those of the next slabs, because a matrix product with few
columns takes longer to call than to compute.
"""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import IndexArray
from ..runtime.threads import chunks

# Threads that change places at every small array wait for the interpreter more than they compute:
# slabs are large, but for meshes that would then have too few for all threads.  Meshes of fewer
# than two of the small ones stay whole.
LARGEST_SLAB, SMALL_SLAB, USUAL_SLABS = 49152, 5000, 4

# A class is uncommon with fewer triangles than this per slab.
UNCOMMON_PER_SLAB = 64

# Chunks of uncommon classes reach over so many slabs at most: what they add up has to be stored for
# all vertices in their reach.  Fewer uncommon classes than this would not pay for that.
MOST_SLABS_TOGETHER, FEWEST_UNCOMMON = 4, 16


def triangle_slabs(n_triangles: int) -> list[slice]:
    """Cut a mesh into slabs; the same on every machine, as results are."""
    size = min(max(-(-n_triangles // USUAL_SLABS), SMALL_SLAB), LARGEST_SLAB)
    return chunks(n_triangles, size)


def chunk_triangles(class_of: IndexArray, class_sizes: IndexArray) -> list[IndexArray]:
    """Part the triangles into chunks, none of them empty.

    Parameters
    ----------
    class_of : (n_triangles,)
        Patch class of each triangle.
    class_sizes : (n_classes,)
        Number of triangles of each class.

    Returns
    -------
    list of (n,) int
        Ascending numbers of triangles.
    """
    slabs = triangle_slabs(len(class_of))
    is_uncommon = class_sizes < UNCOMMON_PER_SLAB * len(slabs)
    n_uncommon = int(class_sizes[is_uncommon].sum())
    # As many as fit without making their chunks larger than a slab.
    n_together = min(MOST_SLABS_TOGETHER, len(slabs) // 2, len(class_of) // max(n_uncommon, 1))
    if np.count_nonzero(is_uncommon) < FEWEST_UNCOMMON or n_together < 2:
        return [np.arange(slab.start, slab.stop) for slab in slabs]
    waits = is_uncommon[class_of]
    own = [slab.start + np.flatnonzero(~waits[slab]) for slab in slabs]
    for run in chunks(len(slabs), n_together):
        first, last = slabs[run.start].start, slabs[run.stop - 1].stop
        own.append(first + np.flatnonzero(waits[first:last]))
    return [triangles for triangles in own if len(triangles)]
