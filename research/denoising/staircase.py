"""The steps that marching cubes leave of a binary volume, on any closed mesh."""

from __future__ import annotations

import igl
import numpy as np
from scipy.spatial.transform import Rotation
from skimage.measure import marching_cubes

from tools.geometry.triangles import Faces, FloatArray

TURN = Rotation.from_euler("xyz", (18, -27, 31), degrees=True).as_matrix()
"""Between the shape and the voxels, so that no flat side is parallel to them."""


def staircase(
    vertices: FloatArray, faces: Faces, n_cells: int
) -> tuple[FloatArray, FloatArray, Faces]:
    """Voxelize a closed mesh and mesh the voxels.

    Parameters
    ----------
    vertices, faces
        The closed clean mesh, (n, 3) and (m, 3).
    n_cells
        Voxels along the longest side of its box.

    Returns
    -------
    clean, noisy, triangles
        Marching cubes of the binary volume: the nearest points of its vertices on the clean mesh,
        the vertices as they come, and the triangles.
    """
    vertices = vertices @ TURN.T
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    cell = float((high - low).max()) / n_cells
    origin = low - 2 * cell
    shape = np.ceil((high - origin) / cell).astype(int) + 3
    points = origin + cell * np.stack(np.indices(shape), axis=-1).reshape(-1, 3)
    faces = faces.astype(np.int64)
    inside = igl.fast_winding_number(vertices, faces, points) > 0.5
    noisy, triangles, _, _ = marching_cubes(inside.reshape(shape).astype(float), 0.5)
    noisy = origin + cell * noisy.astype(float)
    clean = igl.point_mesh_squared_distance(noisy, vertices, faces)[2]
    # scikit-image orients by the gradient's direction: outwards here, where the field falls.
    return clean @ TURN, noisy @ TURN, triangles[:, ::-1].astype(np.int32)
