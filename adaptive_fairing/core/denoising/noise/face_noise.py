"""Smooth noise on flat faces, where no shape hides it.

The residuals of positions on a fitted plane are noise, however wide and however strong.  Their size
is the level, and their size in bands of several widths gives the correlation.  On a clean model
they are rounding.  Texture on flat faces differs from noise as elsewhere: noise is even, has the
strengths of averaged white noise band by band, and is normally distributed (`smooth_noise`).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ...mesh.normals import dots
from ...runtime.arrays import BoolArray, FloatArray, IntArray
from ..flat_faces import FlatFaces
from ..noise_model import NoiseCorrelation, averaged_noise
from ..parameters import parameters
from ..triangle_surface import TriangleSurface
from .noisy_surface import NoisySurface
from .own_numbers import SEVERAL_NOISES, WHITE_NOISE
from .smooth_noise import (
    LEAST_STRENGTH,
    NORMAL_TAIL,
    PASSES,
    TAIL,
    SmoothNoise,
    band_heights,
    leaning,
    least_evenness,
    local_strengths,
    typical_sizes,
    with_presence,
)

# Weights of the bands in the fit.  The narrowest one shows the edges of the mesh as well.
WEIGHTS = np.array([0.0, 1.0, 1.0, 1.0])

# Fraction of the vertices that must lie well inside flat faces.  With 0.12, two more of 370 clean
# meshes with detail all over them were taken for noisy ones.
LEAST_INSIDE = 0.15


def face_noise(
    surface: NoisySurface, faces: FlatFaces, is_counted: BoolArray
) -> SmoothNoise | None:
    """Measure the deviations of a surface from the planes of its flat faces; None without any.

    A plane hides no shape, so even odds suffice for noise that is everywhere (`with_presence`).  It
    was told on 66 of 78 noisy tuning meshes with flat faces.

    Parameters
    ----------
    surface : NoisySurface
    faces : FlatFaces
        Flat faces, found in spite of smooth noise.
    is_counted : (n,) bool
        Vertices to judge from.
    """
    tuned, planes = parameters(), faces.planes
    face = np.where(is_counted, faces.of_vertices(), -1)
    counts = np.bincount(face[face >= 0], minlength=len(planes))
    is_small = np.append(counts < tuned.fewest, True)
    face[is_small[face]] = -1
    is_inner = face >= 0
    n_inner = int(np.count_nonzero(is_inner))
    if n_inner < max(tuned.fewest_to_tell, LEAST_INSIDE * np.count_nonzero(is_counted)):
        return None
    frame = _within_faces(surface, face, planes.normals)
    off_plane = planes.heights(surface.positions, face)[:, None] * planes.normals[face]
    heights = np.where(is_inner, frame.along_normal(off_plane), 0.0)
    totals = np.bincount(face[is_inner], heights[is_inner] ** 2, len(planes))
    sizes = np.sqrt(totals / np.maximum(counts, 1))
    typical = float(np.median(sizes[face[is_inner]]))
    if typical < tuned.clean_roughness:
        return SmoothNoise(typical)
    # Each face counts in its own unit: a scanner may see some of them at a grazing angle.
    relative = heights / np.maximum(sizes[face], tuned.clean_roughness**2)
    bands = band_heights(frame.raised(relative), frame)
    found = np.log(np.maximum(typical_sizes(bands[:, is_inner]), LEAST_STRENGTH))

    def compared(use: float, passes: int) -> tuple[NoiseCorrelation, FloatArray, FloatArray]:
        """Draw a noise of unit size: its correlation, bands (k, n), and how they differ, (k,)."""
        white = surface.own.noise(use)
        noise, correlation = averaged_noise(white, passes, frame, is_inner)
        of_noise = band_heights(frame.raised(noise / correlation.deviation), frame)
        return correlation, of_noise, found - np.log(typical_sizes(of_noise[:, is_inner]))

    def misfit(differences: FloatArray) -> float:
        return float(WEIGHTS @ np.square(differences))

    passes = min(PASSES, key=lambda tried: misfit(compared(WHITE_NOISE, tried)[-1]))
    same = [compared(use, passes) for use in SEVERAL_NOISES]
    (correlation, *_), of_noises, differences = zip(*same, strict=True)
    # The three numbers of a plane take away the noise of as many vertices, if each had its own.
    fitted = np.minimum(3 / correlation.deviation**2, counts / 2)
    levels = np.sqrt(totals / np.maximum(counts - fitted, 1))
    strengths = local_strengths(bands, frame, is_inner)
    evennesses = [
        least_evenness(strengths, local_strengths(each, frame, is_inner), 0.5) for each in of_noises
    ]
    local = bands[:2, is_inner] / strengths[:2]
    local /= np.maximum(typical_sizes(local), 1e-9)[:, None]
    tails = np.array([_tail(local[1]), _tail(relative[is_inner])])
    level = float(np.median(levels[face[is_inner]]))
    told = SmoothNoise(
        level,
        correlation,
        misfit(np.mean(differences, axis=0)),
        evenness=float(np.mean(evennesses)),
        # Too few outliers are as little like noise as too many.
        outliers=float(np.maximum(tails, 1 / np.maximum(tails, 1e-9)).max()),
        lean=leaning(local),
    )
    return with_presence(told, surface, is_counted)


def _tail(values: FloatArray) -> float:
    """Size of the largest values relative to a normal distribution."""
    size = np.abs(values)
    return float(np.quantile(size, TAIL) / max(np.median(size), 1e-9)) / NORMAL_TAIL


def _within_faces(surface: NoisySurface, face: IntArray, normals: FloatArray) -> TriangleSurface:
    """Return a frame that averages within the faces of vertices, (n,), along their planes' normals.

    A vertex without a face, or without a neighbour on it, is an average of itself.
    """
    frame = surface.frame
    n = len(face)
    links = sparse.coo_array(surface.topology.adjacency(np.float64))
    first, second = links.coords
    is_inside = (face[first] == face[second]) & (face[first] >= 0)
    first, second = first[is_inside], second[is_inside]
    count = np.bincount(first, minlength=n)
    alone = np.flatnonzero(count == 0)
    weights = np.concatenate([1 / count[first], np.ones(len(alone))])
    places = np.concatenate([first, alone]), np.concatenate([second, alone])
    mean = sparse.csr_array((weights, places), shape=(n, n))
    # The one of a plane's two normals that is on the surface's side.
    side = np.where(dots(normals[face], frame.normals) < 0, -1.0, 1.0)
    along = np.where((face >= 0)[:, None], side[:, None] * normals[face], frame.normals)
    return frame.with_frame(normals=along, mean=mean)
