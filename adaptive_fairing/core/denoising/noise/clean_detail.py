"""Detail of clean meshes that is as rough as noise in every contrast.

Modelled meshes are full of repetition: rings, mirrored halves, arrays, subdivided flat faces.
Their triangles have twins with the same three lengths, to the last digit of single precision.
With noise two triangles agree only by chance.  The number of chance pairs is estimated with a
tolerance wider by a factor, which raises it by at least the square of the factor.

Contours of whole voxels repeat themselves too, but their flat steps are noise and not shape.  Like
those of a model, their triangles have few kinds of edges.  But their vertices deviate in many more
ways than there are edges.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ...mesh.normals import dots
from ...runtime.arrays import BoolArray, FloatArray, IndexArray, IntArray, LongArray
from ...runtime.lazy import cached_property
from ..parameters import parameters
from .noisy_surface import NoisySurface

# Lengths agree if they differ by at most this times the mesh's half size: eight units of single
# precision.  Chance is measured with a tolerance that is wider by the second number.
TOLERANCE = 8 * 2.0**-23
WIDER = 64

# At least this fraction of a model's triangles has a twin. In meshes with noise of 0.05 or more at
# most 0.001 have, with spikes alone more. With 0.03 and 0.3 no verdict on 447 clean meshes changed.
LEAST_REPEATED = 0.1

# Edges are of one kind if they differ by at most this, relative to the longest one.
COARSE = 1e-3

# Contoured voxels have at most so many kinds of edges; marching cubes have 27. Only a limit of the
# time: with three and ten times as many every verdict on 447 clean meshes was the same.
MOST_KINDS_OF_EDGES = 100

# Odd numbers without any relation to each other.
LABEL_FACTORS = np.random.default_rng(0).integers(1 << 61, 1 << 62, 3) | 1

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
        """Text on the exact copies among the triangles at vertices, (n,) bool; "" without any.

        Meshes of a camera or a scanner with rounded depths have copies too.
        """
        surface = self._surface
        if surface.cosines is not None:
            return ""
        part = repeated_part(self._triangles_at(is_counted), surface.positions)
        return f"{100 * part:.0f} % of its triangles are exact copies of others" if part else ""

    def is_contour(self, is_counted: BoolArray) -> bool:
        """Whether the triangles at vertices, (n,) bool, are the contour of whole voxels."""
        return is_voxel_contour(self._triangles_at(is_counted), self._surface.positions)

    def bends(self, is_counted: BoolArray) -> str:
        """Text on signs that vertices, (n,) bool, belong to a bent low-poly model; "" without any.

        Small parts, such as the eyes of a head, go with the whole.
        """
        tuned = parameters()
        if np.count_nonzero(is_counted) < tuned.fewest_to_tell:
            return self._of_whole
        _, kept = self._surface.fading.of_mesh(is_counted)
        return self._said_of(is_counted) if kept > tuned.least_kept else ""

    def _triangles_at(self, is_counted: BoolArray) -> IntArray:
        triangles = self._surface.topology.triangles
        return triangles[is_counted[triangles].any(axis=1)]

    @cached_property
    def _of_whole(self) -> str:
        return self._said_of(self._all_counted)

    def _said_of(self, is_counted: BoolArray) -> str:
        """Text on signs that vertices, (n,) bool, are a bent low-poly shape; "" without any.

        The measure is the deviation of a vertex from the mean of its neighbours.  In white noise it
        is independent of the neighbours' deviations; on a smooth shape they are nearly equal.
        """
        tuned = parameters()
        if np.count_nonzero(self._all_counted) > tuned.low_poly:
            return ""
        rises = self._surface.frame.rises(self._surface.positions)
        of_mesh, of_noise = self._alikeness(rises, is_counted), self._expected(is_counted)
        alike = (of_mesh - of_noise) / max(1 - of_noise, 1e-9)
        if alike < tuned.least_bend_correlation:
            return ""
        return (
            f"neighbouring vertices stand out alike by {100 * alike:.0f} %, as where a shape bends"
        )

    def _alikeness(self, own: FloatArray, is_counted: BoolArray) -> float:
        """Correlation of the deviations (n,) from the neighbours' mean with the neighbours'."""
        around = self._surface.frame.mean @ own
        own, around = own[is_counted], around[is_counted]
        size = float(own.std() * around.std())
        return float(np.mean((own - own.mean()) * (around - around.mean()))) / size if size else 0.0

    def _expected(self, is_counted: BoolArray) -> float:
        """Correlation that white noise has: `_alikeness` of many noises.

        Row i of a matrix has what every vertex, raised by one local edge, adds to deviation i.
        """
        frame = self._surface.frame
        mean, size = frame.mean.tocoo(), frame.spacing
        at, of = mean.coords
        along = dots(frame.normals[at], frame.normals[of]) * size[of] / size[at]
        beside = sparse.csr_array((mean.data * along, (at, of)), shape=mean.shape)
        deviations = sparse.csr_array(sparse.identity(len(size), format="csr") - beside)
        own, around = deviations[is_counted], (frame.mean @ deviations)[is_counted]
        sizes = np.sqrt(own.power(2).sum() * around.power(2).sum())
        return float(own.multiply(around).sum() / sizes) if sizes else 0.0


def repeated_part(triangles: IntArray, positions: FloatArray) -> float:
    """Fraction of the triangles (m, 3) with exact twins, 0 to 1; 0 if chance explains them.

    The positions (n, 3) are centred: the tolerance follows the size of the numbers.
    """
    tuned = parameters()
    if len(triangles) == 0:
        return 0.0
    corners = positions[triangles]
    lengths = np.sort(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1)
    tolerance = TOLERANCE * float(np.abs(corners).max())
    pairs = _others_alike(lengths, tolerance)
    part = float(np.mean(pairs > 0))
    if part < LEAST_REPEATED:
        return 0.0
    by_chance = np.mean(_others_alike(lengths, WIDER * tolerance)) / WIDER**2
    return part if np.mean(pairs) > tuned.least_over_chance * by_chance else 0.0


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


def _others_alike(values: FloatArray, tolerance: float) -> IndexArray:
    """Count the other rows of (m, k) that are equal after rounding to the tolerance, (m,)."""
    labels = _labels(np.round(values / tolerance).astype(np.int64))
    _, kind, counts = np.unique(labels, return_inverse=True, return_counts=True)
    return counts[kind] - 1


def _n_kinds(vectors: FloatArray) -> int:
    """Count the distinct rows of (m, 3) up to their sign."""
    rounded = np.round(vectors / COARSE).astype(np.int64)
    leading = np.argmax(rounded != 0, axis=1)
    sign = np.sign(rounded[np.arange(len(rounded)), leading])
    return len(np.unique(_labels(rounded * sign[:, None])))


def _labels(rows: LongArray) -> LongArray:
    """Give equal rows of (m, 3) one number and others different ones: one number sorts faster.

    That two of a million rows get the same one by chance has a probability of 1e-7.
    """
    labels: LongArray = (rows * LABEL_FACTORS).sum(axis=1)  # modulo 2⁶⁴
    return labels
