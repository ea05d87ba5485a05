"""Limit of the motion along the surface, and triangles that it keeps from turning over."""

import numpy as np
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.bounds import Sliding
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

SPHERE = meshes.icosphere(3)


def sliding(positions, faces, noise=0.2):
    start = TriangleSurface(TriangleTopology(faces, len(positions)), positions)
    levels = np.broadcast_to(noise, len(positions))
    return Sliding(start, start, levels)


def face_normals(positions, faces):
    corner = positions[faces]
    return np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])


def n_turned(before, after, faces):
    cosines = np.einsum("fd,fd->f", face_normals(before, faces), face_normals(after, faces))
    return np.count_nonzero(cosines < 0)


def slid(vertices, faces):
    """Move one vertex along the sphere over the opposite edge of a triangle, and all inwards."""
    moved = 0.98 * vertices
    moved[faces[0, 0]] = 0.98 * (
        vertices[faces[0, 1]] + vertices[faces[0, 2]] - vertices[faces[0, 0]]
    )
    return moved


def test_a_triangle_turned_over_is_turned_back():
    vertices, faces = SPHERE
    moved = slid(vertices, faces)
    assert n_turned(vertices, moved, faces) > 0
    assert n_turned(vertices, sliding(*SPHERE).limited(moved), faces) == 0


def test_moves_along_the_normal_are_kept():
    vertices, faces = SPHERE
    moved = slid(vertices, faces)
    result = sliding(*SPHERE).limited(moved)
    along_normal = np.einsum("nd,nd->n", result - moved, vertices)
    assert np.abs(along_normal).max() < 0.02  # not the 0.13 that the vertex went back
    changed = np.linalg.norm(result - moved, axis=1) > 3e-4
    near = np.unique(faces[np.isin(faces, faces[0, 0]).any(axis=1)])
    assert np.isin(np.flatnonzero(changed), near).all()


def test_vertices_go_a_fraction_of_their_way_along_the_surface():
    vertices, _ = SPHERE
    axis, angle = np.array([0, 0, 1.0]), 0.02
    along = angle * np.cross(axis, vertices)
    result = sliding(*SPHERE).limited(0.97 * vertices + along)
    np.testing.assert_allclose(
        result, 0.97 * vertices + PARAMETERS.sliding_fraction * along, atol=3e-4
    )


def test_no_vertex_goes_further_along_the_surface_than_its_noise():
    vertices, faces = SPHERE
    along = 0.1 * np.cross([0, 0, 1.0], vertices)
    start = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    noise = np.linspace(0, 0.2, len(vertices))
    faired = 0.97 * vertices + along
    way = sliding(*SPHERE, noise).limited(faired) - vertices
    normals = faired / np.linalg.norm(faired, axis=1)[:, None]  # they turn with the sphere
    way -= np.einsum("nd,nd->n", way, normals)[:, None] * normals
    assert np.all(np.linalg.norm(way, axis=1) <= noise * start.spacing + 1e-3)
    assert np.linalg.norm(along, axis=1).max() > 0.4 * start.spacing.max()


def test_what_was_folded_before_is_not_judged():
    vertices, faces = SPHERE
    folded = slid(vertices, faces)
    corner = faces[0, 0]
    along = 0.05 * np.cross(folded[corner], vertices[faces[0, 1]])
    moved = folded.copy()
    moved[corner] += along
    assert n_turned(folded, moved, faces) == 0
    went = sliding(folded, faces).limited(moved)[corner] - folded[corner]
    np.testing.assert_allclose(
        went, PARAMETERS.sliding_fraction * along, atol=0.1 * np.linalg.norm(along)
    )


def test_where_the_noise_is_as_large_as_the_edges_vertices_go_all_of_their_way():
    vertices, faces = SPHERE
    moved = slid(vertices, faces)
    corner = faces[0, 0]
    is_loud = np.arange(len(vertices)) == corner
    result = sliding(vertices, faces, np.where(is_loud, 1.5, 0.2)).limited(moved)
    assert np.array_equal(result[corner], moved[corner])
    # The others go as if that triangle was not turned over, but it turns the normals around.
    is_beside = np.isin(np.arange(len(vertices)), faces[np.isin(faces, corner).any(axis=1)])
    for some, tolerance in ((~is_beside, 3e-4), (is_beside & ~is_loud, 5e-4)):
        np.testing.assert_allclose(result[some], 0.98 * vertices[some], atol=tolerance)


def test_no_triangle_of_an_uneven_boundary_is_turned_over():
    vertices, faces = uneven_sheet()
    # Where a part is clean, the others have features, if nobody says that they have noise.
    settings = DenoiseSettings(boundary="free", clean="denoise")
    faired = denoise(vertices, faces, settings).positions
    assert np.abs(faired - vertices).max() > 0
    assert (face_normals(faired, faces)[:, 2] > 0).all()


def uneven_sheet(n=24, amplitude=0.2):
    """A noisy sheet whose rows at one side are ever narrower."""
    x, y = np.meshgrid(np.arange(n, dtype=float), np.arange(n, dtype=float), indexing="ij")
    x[-4:] = x[-5, 0] + np.array([0.4, 0.6, 0.7, 0.75])[:, None]
    height = np.sin(x / 6) * np.cos(y / 6)
    height += amplitude * np.random.default_rng(0).normal(size=height.shape) * (x < x[-5, 0])
    index = np.arange(n * n).reshape(n, n)
    a, b, c, d = (
        part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    )
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.stack([x, y, height], axis=-1).reshape(-1, 3), faces
