"""Meshes as scanners see a surface: a depth camera's, a range scanner's, a binary volume's.

All give the clean positions of the same vertices: where their rays meet the surface, or the points
of the surface nearest to them.
"""

from __future__ import annotations

import bpy  # noqa: F401  mathutils exists once it has been imported
import numpy as np
from mathutils.bvhtree import BVHTree
from scipy.ndimage import binary_opening, gaussian_filter

from tools.geometry.triangles import (
    Faces,
    FloatArray,
    grid_faces,
    local_edge_lengths,
    scaled_normals,
)

Scan = tuple[FloatArray, FloatArray, Faces]
"""Clean positions (n, 3), noisy positions (n, 3), triangles (m, 3)."""

VIEW = np.array([0.35, -0.75, 0.55])
"""From the surface to the scanner, which is so far away that its rays are parallel."""

PIXEL = 0.6
"""Distance of the rays over the mean edge: so many that the mesh keeps the surface's detail."""

STEEPEST = 4.0
"""A triangle whose corners differ more in depth, over the distance of the rays, is left out."""

FILTER = 1.2
"""Standard deviation in pixels of the camera's own smoothing: noise is then alike by about 0.8, 0.5
and 0.2 over one, two and three pixels, as measured on depth cameras."""

LINES = 1.5
"""Distance of a range scanner's lines over the distance of the points on a line."""


def depth_camera(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> Scan:
    """See a surface with a depth camera: depths in steps, then smoothed.

    Parameters
    ----------
    vertices, faces
        The clean surface, (n, 3) and (m, 3).
    amplitude
        Step of the depth over the distance of two pixels. Before it is rounded the depth has noise
        of half a step.
    generator
        Of the random numbers.
    """
    pixel = PIXEL * local_edge_lengths(vertices, faces).mean()
    image = DepthImage(vertices, faces, pixel, pixel)
    step = amplitude * pixel
    # Camera and surface are not aligned: where the steps fall is random.
    offset = generator.uniform(0, step)
    measured = image.depth + offset + 0.5 * step * generator.normal(size=image.depth.shape)
    measured = step * np.round(measured / step) - offset
    return image.mesh(_smoothed(measured, image.depth, image.seen))


def range_scanner(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> Scan:
    """See a surface with a laser scanner that measures line by line.

    The errors lie along the line of sight, are alike along a line and grow where it is grazing.

    Parameters
    ----------
    vertices, faces
        The clean surface, (n, 3) and (m, 3).
    amplitude
        Root mean square error, where the laser meets the surface at a right angle, over the
        distance of two points on a line.
    generator
        Of the random numbers.
    """
    pixel = PIXEL * local_edge_lengths(vertices, faces).mean()
    image = DepthImage(vertices, faces, pixel, LINES * pixel)
    shape = image.depth.shape
    along = gaussian_filter(generator.normal(size=shape), (0, 1.0))
    lines = generator.normal(size=(shape[0], 1))
    parts = 0.75**0.5, 0.2**0.5 / along.std(), 0.05**0.5
    error = parts[0] * generator.normal(size=shape) + parts[1] * along + parts[2] * lines
    return image.mesh(image.depth + amplitude * pixel * error / np.maximum(image.cosine, 0.3))


class DepthImage:
    """Depths of a surface seen along parallel rays.

    Parameters
    ----------
    vertices, faces
        The surface, (n, 3) and (m, 3).
    width, height
        Distances of the rays.
    view
        From the surface to the camera, (3,), of any length; not upright.

    Attributes
    ----------
    frame
        Axes of the image, right, up and towards the camera, in rows (3, 3).
    x, y, depth, cosine
        Of every ray: where it is, where the surface is along it, and how steeply it is seen.
    seen
        Where it meets the surface.
    """

    def __init__(
        self,
        vertices: FloatArray,
        faces: Faces,
        width: float,
        height: float,
        view: FloatArray = VIEW,
    ) -> None:
        toward = view / np.linalg.norm(view)
        right = np.cross([0.0, 0.0, 1.0], toward)
        right /= np.linalg.norm(right)
        self.frame = np.stack([right, np.cross(toward, right), toward])
        local = vertices @ self.frame.T
        low, high = local.min(axis=0), local.max(axis=0)
        columns = np.arange(low[0] + 0.5 * width, high[0], width)
        rows = np.arange(low[1] + 0.5 * height, high[1], height)
        self.x, self.y = np.meshgrid(columns, rows)
        self.limit = STEEPEST * max(width, height)
        shape = self.x.shape
        self.depth, self.cosine = np.zeros(shape), np.zeros(shape)
        tree = BVHTree.FromPolygons(local.tolist(), faces.tolist())
        top = high[2] + 1.0
        normals = scaled_normals(local, faces)
        for place in np.ndindex(shape):
            hit, _, face, _ = tree.ray_cast((self.x[place], self.y[place], top), (0, 0, -1))
            if hit is not None:
                # Blender's own point is in single precision: the plane of the face is exact.
                normal, corner = normals[face], local[faces[face, 0]]
                gap = normal[:2] @ (corner[:2] - [self.x[place], self.y[place]])
                self.cosine[place] = normal[2] / np.linalg.norm(normal)
                if self.cosine[place] > 0.1:
                    self.depth[place] = corner[2] + gap / normal[2]
        # Squares of pixels alone: no two parts hang together at a single vertex of a line.
        self.seen = binary_opening(self.cosine > 0.1, np.ones((2, 2)))

    def mesh(self, depth: FloatArray) -> Scan:
        """Join neighbouring rays to triangles; the surface's own depths say which."""
        faces = grid_faces(*depth.shape, (False, False))[:, ::-1]
        corners = self.depth.ravel()[faces]
        kept = self.seen.ravel()[faces].all(axis=1) & (np.ptp(corners, axis=1) < self.limit)
        used, faces = np.unique(faces[kept], return_inverse=True)
        clean, noisy = (
            np.stack([self.x, self.y, z], axis=-1).reshape(-1, 3)[used] @ self.frame
            for z in (self.depth, depth)
        )
        return clean, noisy, faces.reshape(-1, 3).astype(np.int32)


def _smoothed(measured: FloatArray, depth: FloatArray, seen: np.ndarray) -> FloatArray:
    """Smooth the errors of a depth image where there is depth.

    A camera's own filter does not smooth over steps of the depth; one that smooths the errors alone
    is an ideal one of that sort.
    """
    error = np.where(seen, measured - depth, 0.0)
    weight = gaussian_filter(seen.astype(float), FILTER)
    return depth + gaussian_filter(error, FILTER) / np.where(seen, weight, 1.0)
