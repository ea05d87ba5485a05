"""Meshes as today's devices give them: structured light, photographs, a volume fused of many views.

As in `scans` the clean positions are of the same vertices.  Strengths and widths are by hand, after
what is known of such devices; nobody's scans were fitted.
"""

from __future__ import annotations

import bpy  # noqa: F401  mathutils exists once it has been imported
import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates, uniform_filter
from scipy.sparse import coo_array, csgraph
from scipy.spatial.transform import Rotation

from tools.geometry.triangles import Faces, FloatArray, local_edge_lengths, vertex_normals

from .detail_alarms import Texture
from .scans import FILTER, PIXEL, STEEPEST, DepthImage, Scan

BLOCK = 5
"""Pixels along the side of the blocks that structured light is matched by."""

MATCHING = 0.5
"""Root mean square error of the matching in steps of the disparity."""

LOCKING, STEPS = 0.4, 8
"""Sub-pixel matching is drawn to whole pixels: by so many steps, of so many to a pixel."""

RANGE = 2.0
"""The camera smooths over neighbours whose disparities differ by about so many steps."""

MISSING = 0.03
"""Part of the pixels that nothing was matched for."""

OCTAVES = (3, 4.5, 7, 10.5)
"""Wavelengths in edges of the bumps of photogrammetry."""

STRETCH = np.array([1.0, 1.0, 2.0])
"""Bumps are so much longer along the direction in which the photographs were taken."""

VIEWS, TRUNCATION, POSE = 20, 3.0, 0.5
"""Views of a hand scanner, the distance in cells at which signed distances are truncated, and the
error of a view's place over that of its depths."""

KEPT = 0.5
"""Part of the triangles of marching cubes that is left after decimation."""


def structured_light(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> Scan:
    """See a surface by structured light: blocks are matched, disparities come in steps.

    Blocks that share pixels share errors, and a block across a step of the depth sees its own side
    alone.  Disparities are drawn to whole pixels, rounded to steps, and smoothed over neighbours
    that are alike; in some spots nothing is found.  The camera is so far away that the depth is
    linear in the disparity.

    Parameters
    ----------
    vertices, faces
        The clean surface, (n, 3) and (m, 3).
    amplitude
        Depth of a step of the disparity over the distance of two pixels.
    generator
        Of the random numbers.
    """
    pixel = PIXEL * local_edge_lengths(vertices, faces).mean()
    image = DepthImage(vertices, faces, pixel, pixel)
    step = amplitude * pixel
    true = image.depth / step + generator.uniform(0, STEPS)
    seen = image.seen.astype(float)
    matched = _among_alike(true, seen, np.ones((BLOCK, BLOCK)), STEEPEST / amplitude)
    error = uniform_filter(generator.normal(size=true.shape), BLOCK)
    matched += MATCHING * error / error.std() - LOCKING * np.sin(2 * np.pi * true / STEPS)
    near = np.exp(-0.5 * (np.arange(-2, 3) / FILTER) ** 2)
    smooth = _among_alike(np.round(matched), seen, np.outer(near, near), RANGE)
    spots = gaussian_filter(generator.normal(size=true.shape), BLOCK / 2)
    image.seen &= spots < np.quantile(spots, 1 - MISSING)
    return image.mesh(image.depth + step * (smooth - true))


def photogrammetry(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> Scan:
    """Give a surface the bumps of photogrammetry: of several widths, longer one way, uneven.

    Parameters
    ----------
    vertices, faces
        The clean surface, (n, 3) and (m, 3).
    amplitude
        Root mean square height over the mean edge.
    generator
        Of the random numbers.
    """
    edge = local_edge_lengths(vertices, faces).mean()
    turned = Rotation.random(random_state=generator).apply(vertices / edge)
    heights = sum(map(Texture(turned / STRETCH, generator).waves, OCTAVES))
    # Where the surface has little texture there is more of them.
    heights *= np.exp(0.3 * Texture(turned, generator).waves(40))
    heights *= amplitude * edge / np.sqrt(np.mean(heights**2))
    return vertices, vertices + heights[:, None] * vertex_normals(vertices, faces), faces


def fused_volume(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> Scan:
    """Fuse depth images from all around into a volume, mesh it and decimate the mesh.

    Parameters
    ----------
    vertices, faces
        The closed clean surface, (n, 3) and (m, 3).
    amplitude
        Root mean square error of a single view's depths over the side of a cell.
    generator
        Of the random numbers.
    """
    import igl
    from skimage.measure import marching_cubes

    from tools.geometry.blender_meshes import add_modifier, evaluated, new_object

    cell = 0.8 * local_edge_lengths(vertices, faces).mean()
    distances, origin = fused_distances(vertices, faces, amplitude, cell, generator)
    points, triangles, _, _ = marching_cubes(distances, 0.0)
    item = new_object(*_without_crumbs(origin + cell * points, triangles))
    add_modifier(item, "DECIMATE", ratio=KEPT)
    noisy, triangles = evaluated(item)
    clean = igl.point_mesh_squared_distance(noisy, vertices, faces.astype(np.int64))[2]
    return clean, noisy, triangles


def fused_distances(
    vertices: FloatArray,
    faces: Faces,
    amplitude: float,
    cell: float,
    generator: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Average the truncated signed distances that views from all around see, in cells.

    Returns
    -------
    distances, origin
        (i, j, k), positive inside, and the place (3,) of the first.  Where no view comes near
        the surface they are those of inside or outside.
    """
    import igl

    low, high = vertices.min(axis=0) - 3 * cell, vertices.max(axis=0) + 3 * cell
    shape = np.ceil((high - low) / cell).astype(int) + 1
    points = low + cell * np.stack(np.indices(shape), axis=-1).reshape(-1, 3)
    total, weight = np.zeros((2, len(points)))
    for view in generator.normal(size=(VIEWS, 3)):
        image = DepthImage(vertices, faces, cell, cell, view)
        error = gaussian_filter(generator.normal(size=image.depth.shape), FILTER)
        error = amplitude * cell * error / error.std() / np.maximum(image.cosine, 0.3)
        wrong = points + POSE * amplitude * cell * generator.normal(size=3)
        local = wrong @ image.frame.T
        places = (local[:, 1::-1].T - np.array([[image.y[0, 0]], [image.x[0, 0]]])) / cell
        depth, cosine, seen = (
            map_coordinates(each, places, order=0)
            for each in (image.depth + error, image.cosine, image.seen.astype(float))
        )
        gap = (local[:, 2] - depth) / cell
        # What is further behind is hidden.  Seen along the ray the distance is longer.
        counts = np.where((seen > 0) & (gap > -TRUNCATION), cosine**2, 0)
        total -= counts * np.minimum(gap * cosine, TRUNCATION)
        weight += counts
    inside = igl.fast_winding_number(vertices, faces.astype(np.int64), points) > 0.5
    unseen = np.where(inside, TRUNCATION, -TRUNCATION)
    fused = np.where(weight > 0, total / np.maximum(weight, 1e-9), unseen)
    return fused.reshape(shape), low


def _without_crumbs(points: FloatArray, faces: Faces) -> tuple[FloatArray, Faces]:
    """Leave pieces out that have less than a hundredth of the faces (m, 3), and their points."""
    rows, columns = faces.ravel(), np.roll(faces, 1, axis=1).ravel()
    links = coo_array((np.ones(len(rows)), (rows, columns)), (len(points), len(points)))
    piece = csgraph.connected_components(links)[1][faces[:, 0]]
    used, faces = np.unique(
        faces[np.bincount(piece)[piece] > len(faces) / 100], return_inverse=True
    )
    return points[used], faces.reshape(-1, 3).astype(np.int32)


def _among_alike(
    values: FloatArray, seen: FloatArray, weights: FloatArray, nearness: float
) -> FloatArray:
    """Average an image over its pixels that were seen and have nearly the same value.

    Parameters
    ----------
    values, seen
        (r, c) the image, and 1 where there is anything to see.
    weights
        (k, k) of the neighbours.
    nearness
        Standard deviation of the values that count.
    """
    reach = len(weights) // 2
    (rows, columns), total, weight = values.shape, 0.0, 1e-12
    padded, known = np.pad(values, reach), np.pad(seen, reach)
    for (i, j), at in np.ndenumerate(weights):
        there = np.s_[i : i + rows, j : j + columns]
        counts = at * known[there] * np.exp(-0.5 * ((padded[there] - values) / nearness) ** 2)
        total, weight = total + counts * (padded[there] - values), weight + counts
    averaged: FloatArray = values + total / weight
    return averaged
