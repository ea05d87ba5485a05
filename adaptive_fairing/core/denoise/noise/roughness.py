"""The roughness of a mesh at each vertex, as white noise would make it."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ...runtime.arrays import FloatArray
from ..local_frame import LocalFrame


def roughness(positions: FloatArray, frame: LocalFrame) -> FloatArray:
    """Measure what two differences with the mean of the neighbours leave: noise for the most part.

    Parameters
    ----------
    positions : (n, 3)
    frame : LocalFrame

    Returns
    -------
    (n,)
        Along the normals, over the deviation that white noise of one local edge length along the
        normals has there.
    """
    difference = sparse.identity(len(positions), format="csr") - frame.mean
    twice = sparse.csr_array(difference @ difference)
    return np.abs(frame.along_normal(twice @ positions)) / _gain(twice, frame)


def _gain(operator: sparse.csr_array, frame: LocalFrame) -> FloatArray:
    """Compute the deviation of the normal part for unit noise along the normals, (n,)."""
    entries = sparse.coo_array(operator)
    row, column = entries.coords
    cosine = np.einsum("ed,ed->e", frame.normals[row], frame.normals[column])
    factor = entries.data * cosine * frame.spacing[column] / frame.spacing[row]
    variance = np.bincount(row, factor**2, len(frame.spacing))
    return np.sqrt(np.maximum(variance, 1e-12))
