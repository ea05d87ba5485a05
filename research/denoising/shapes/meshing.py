"""From exact or dense meshes to clean ones of uneven density: remeshing, quadric decimation."""

from __future__ import annotations

import bpy
import numpy as np
import pymeshlab

from research.samples.adaptive import decimate, flip_edges
from tools.geometry.triangles import Faces, FloatArray

MeshArrays = tuple[FloatArray, Faces]

SPECKS, SPECK_ROUNDS = 4, 4
"""Specks of tiny triangles in a mesh, and how often each is refined."""

FOLDS, FOLD_REACH = 20, 1.5
"""Folds in a mesh, and how far their vertices are pushed, over the edge that they are pushed along.
"""


def remeshed(vertices: FloatArray, faces: Faces, edge: float, crease: float = 25.0) -> MeshArrays:
    """Return triangles of nearly one size that keep sharp edges.

    Parameters
    ----------
    vertices, faces
        (n, 3) positions and (m, 3) triangles, however uneven.
    edge
        Length of the new edges.
    crease
        Edges bent by more than this many degrees are kept.
    """
    meshes = _loaded(vertices, faces)
    meshes.meshing_merge_close_vertices(threshold=pymeshlab.PureValue(1e-4 * edge))
    meshes.meshing_isotropic_explicit_remeshing(
        iterations=12, targetlen=pymeshlab.PureValue(edge), featuredeg=crease, checksurfdist=False
    )
    return _arrays(meshes)


def graded(
    vertices: FloatArray, faces: Faces, n_triangles: int, importance: FloatArray
) -> MeshArrays:
    """Collapse edges by quadric error, more of them where the importance (n,) is small."""
    meshes = _loaded(vertices, faces, importance)
    meshes.meshing_decimation_quadric_edge_collapse(
        targetfacenum=n_triangles,
        qualitythr=0.5,
        qualityweight=True,
        planarquadric=True,
        planarweight=0.002,
        preservenormal=True,
        preservetopology=True,
        preserveboundary=True,
    )
    return _arrays(meshes)


def uneven(
    vertices: FloatArray, faces: Faces, n_triangles: int, importance: FloatArray
) -> MeshArrays:
    """Collapse edges of a closed smooth mesh where the importance (n,) in [0, 1] is small.

    More uneven than `graded`; it has no eye for long flat sides.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    vertices, faces = decimate(vertices, faces, importance, n_triangles, contrast=8.0)
    return vertices, flip_edges(vertices, faces, flat=0.7)


def speckled(vertices: FloatArray, faces: Faces) -> MeshArrays:
    """Refine the triangles around four vertices again and again, as bad cuts of solids leave them.

    Edges become up to some twenty times as short there.
    """
    generator = np.random.default_rng(5)
    for centre in generator.choice(len(vertices), SPECKS, replace=False):
        for _ in range(SPECK_ROUNDS):
            is_near = (faces == centre).any(axis=1)
            ring = [np.roll(face, -face.tolist().index(centre)) for face in faces[is_near]]
            middle: dict[int, int] = {}
            points, triangles = [], []
            for corner in (int(each) for face in ring for each in face):
                if corner != centre and corner not in middle:
                    middle[corner] = len(vertices) + len(points)
                    way = vertices[corner] - vertices[centre]
                    points.append(vertices[centre] + (0.4 + 0.15 * generator.random()) * way)
            for _, a, b in ring:
                c, d = middle[a], middle[b]
                triangles += [(centre, c, d), (c, a, b), (c, b, d)]
            vertices = np.concatenate([vertices, points])
            faces = np.concatenate([faces[~is_near], np.array(triangles, dtype=faces.dtype)])
    return vertices, faces


def folded(vertices: FloatArray, faces: Faces) -> MeshArrays:
    """Push some vertices over one of their neighbours, as bad cuts of solids leave them."""
    generator = np.random.default_rng(6)
    vertices = vertices.copy()
    for centre in generator.choice(len(vertices), FOLDS, replace=False):
        ring = np.setdiff1d(faces[(faces == centre).any(axis=1)], centre)
        vertices[centre] += FOLD_REACH * (vertices[ring[0]] - vertices[centre])
    return vertices, faces


def near(vertices: FloatArray, centre: tuple[float, ...], radius: float, least: float = 1e-3):
    """Return an importance (n,): 1 at a centre, falling to `least` beyond some radii of it."""
    squares = np.sum(np.square((vertices - np.array(centre)) / radius), axis=1)
    return least + (1 - least) * np.exp(-squares)


def _loaded(
    vertices: FloatArray, faces: Faces, quality: FloatArray | None = None
) -> pymeshlab.MeshSet:
    options = {} if quality is None else {"v_scalar_array": np.ascontiguousarray(quality)}
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.ascontiguousarray(vertices, dtype=float), faces, **options))
    return meshes


def _arrays(meshes: pymeshlab.MeshSet) -> MeshArrays:
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix().copy(), mesh.face_matrix().astype(np.int32)
