"""Detail of clean meshes that is as rough as noise in every contrast.

Modelled meshes are full of repetition: rings, mirrored halves, arrays, subdivided flat faces.
A triangle and the nine around it then have the same lengths as another ten, to the digits of single
precision.  In a noisy mesh a triangle may have the lengths of another by chance, as coordinates
are rounded.  The nine around it do not.

Contours of whole voxels repeat themselves too, but their flat steps are noise and not shape.  Like
those of a model, their triangles have few kinds of edges.  But their vertices deviate in many more
ways than there are edges.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...mesh.topology import TriangleTopology
from ...runtime.arrays import BoolArray, FloatArray, IntArray, LongArray
from ...runtime.lazy import cached_property
from ..parameters import parameters
from .laid_edges import laid_excess
from .noisy_surface import NoisySurface
from .own_numbers import hashed

# Lengths agree if they are the same multiple of this times the mesh's half size, 64 units of single
# precision: fewer would part twins.  Triangles agree if those across edges do, so many times over.
TOLERANCE = 64 * 2.0**-23
AROUND = 2

# At least this fraction of a model's triangles has a twin.  Fourteen models had 0.48 to 1, the same
# with noise that was rounded to its own size at most 0.01.
LEAST_REPEATED = 0.1

# Edges are of one kind if they differ by at most this, relative to the longest one.
COARSE = 1e-3

# Contoured voxels have at most so many kinds of edges; marching cubes have 27. Only a limit of the
# time: with three and ten times as many every verdict on 447 clean meshes was the same.
MOST_KINDS_OF_EDGES = 100

# Any other mesh has too many kinds of edges in so few triangles: to count them all takes long.
FIRST_TRIANGLES = 512


class CleanDetail:
    """Signs by which the detail of a clean mesh differs from noise.

    Parameters
    ----------
    surface : NoisySurface
    is_counted : (n,) bool
        Vertices of the whole mesh to judge from.
    """

    def __init__(self, surface: NoisySurface, is_counted: BoolArray) -> None:
        self._surface, self._all_counted = surface, is_counted

    def fades(self, is_counted: BoolArray) -> bool:
        """Whether vertices, (n,) bool, have detail as fine as the mesh.

        Such detail fades in differences of higher order, while white noise does not.
        """
        fading = self._surface.fading
        rough, _ = fading.of_mesh(is_counted)
        return fading.fades(is_counted) and rough < parameters().least_roughness

    def copies(self, is_counted: BoolArray) -> str:
        """Text on the exact copies among the triangles at vertices, (n,) bool; "" without any."""
        part = float(np.mean(self._are_repeated[self._are_at(is_counted)]))
        if part < LEAST_REPEATED:
            return ""
        return f"{100 * part:.0f} % of its triangles are exact copies of others"

    def is_contour(self, is_counted: BoolArray) -> bool:
        """Whether the triangles at vertices, (n,) bool, are the contour of whole voxels."""
        triangles = self._surface.topology.triangles[self._are_at(is_counted)]
        return is_voxel_contour(triangles, self._surface.positions)

    def shape(self, is_counted: BoolArray, level: FloatArray) -> tuple[float, str]:
        """Signs that vertices, (n,) bool, are rough by their shape, and a text on them.

        Noise knows no edges, and does not fade in differences of higher order.  `level` (n,) is
        that of the noise, if it is noise, in local edge lengths.  From 1 on it is shape.
        """
        tuned = parameters()
        # Small parts, such as the eyes of a head, are judged with the whole.
        is_small = np.count_nonzero(is_counted) < tuned.fewest_to_tell
        judged = self._all_counted if is_small else is_counted
        better, evened = laid_excess(self._surface, level, judged)
        faded = 1 - self._surface.fading.of_mesh(judged)[1]
        better, evened, faded = (max(each, 0.0) for each in (better, evened, faded))
        # Noise that is alike at neighbours has the last two, but not the first.
        signs = float(np.sqrt(better * (better + evened + faded)))
        return signs / tuned.most_shape, (
            f"{100 * better:.0f} % more of its edges follow bends than noise would leave, longer "
            f"ones bend less by a correlation of {evened:.2f}, and its roughness fades by "
            f"{100 * faded:.0f} %"
        )

    def _are_at(self, is_counted: BoolArray) -> BoolArray:
        """Whether each triangle has one of some vertices, (n,) bool."""
        at: BoolArray = is_counted[self._surface.topology.triangles].any(axis=1)
        return at

    @cached_property
    def _are_repeated(self) -> BoolArray:
        return are_repeated(self._surface.topology, self._surface.positions)


def are_repeated(topology: TriangleTopology, positions: FloatArray) -> BoolArray:
    """Whether each triangle has an exact twin, and so have those around it, (m,).

    The positions (n, 3) are centred: the tolerance follows the size of the numbers.
    """
    corners = positions[topology.triangles]
    lengths = np.sort(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1)
    tolerance = TOLERANCE * float(np.abs(corners).max(initial=np.finfo(float).tiny))
    labels = _labels(np.round(lengths / tolerance).astype(np.int64))
    # Without a triangle across, twin is -1: the last row.
    across = (topology.twin // 3).reshape(-1, 3)
    for _ in range(AROUND):
        of_others = np.append(hashed(labels), np.uint64(0))[across].sum(axis=1)
        labels = hashed(3 * labels + of_others)
    _, kind, counts = np.unique(labels, return_inverse=True, return_counts=True)
    repeated: BoolArray = counts[kind] > 1
    return repeated


def is_voxel_contour(triangles: IntArray, positions: FloatArray) -> bool:
    """Whether triangles (m, 3) are the contour of a volume of whole voxels."""
    tuned = parameters()
    corners = positions[triangles]
    edges = (corners - np.roll(corners, 1, axis=1)).reshape(-1, 3)
    longest = float(np.linalg.norm(edges, axis=1).max(initial=0))
    if not longest > 0 or _n_kinds(edges[: 3 * FIRST_TRIANGLES] / longest) > MOST_KINDS_OF_EDGES:
        return False
    n_edges = _n_kinds(edges / longest)
    if n_edges > MOST_KINDS_OF_EDGES:
        return False
    # Every triangle adds its two edges at a corner.
    opened = 2 * corners - np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    stands_out = np.zeros_like(positions)
    np.add.at(stands_out, triangles, opened / longest)
    used = np.unique(triangles)
    return _n_kinds(stands_out[used]) >= tuned.least_kinds_of_vertices * n_edges


def _n_kinds(vectors: FloatArray) -> int:
    """Count the distinct rows of (m, 3) up to their sign."""
    rounded = np.round(vectors / COARSE).astype(np.int64)
    leading = np.argmax(rounded != 0, axis=1)
    sign = np.sign(rounded[np.arange(len(rounded)), leading])
    return len(np.unique(_labels(rounded * sign[:, None])))


def _labels(rows: LongArray) -> NDArray[np.uint64]:
    """Give equal rows of (m, 3) one number and others different ones: one number sorts faster.

    That two of a million rows get the same one by chance has a probability of 1e-7.
    """
    labels = np.zeros(len(rows), np.uint64)
    for column in rows.T:
        labels = hashed(labels + column.astype(np.uint64))
    return labels
