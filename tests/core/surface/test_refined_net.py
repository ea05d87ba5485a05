"""Values on a refined net: linear on points and corners, inherited by faces and edges."""

import numpy as np
import pytest
from support import bad_meshes, meshes
from support.reference import fine_barycentric

from adaptive_fairing.core.surface.cut_surface import cut_surface
from adaptive_fairing.core.surface.refined_net import RefinedNet

NONE = np.empty((0, 2), dtype=np.int64)
NO_VERTEX = np.empty(0, dtype=np.int64)
CASES = {
    "closed": meshes.random_closed(1),
    "open": meshes.bumpy_disc(0),
    "three sheets": bad_meshes.three_sheets(),
    "turned": bad_meshes.turned(),
    "one-sided": bad_meshes.moebius_strip(),
    "touching": bad_meshes.bow_tie(),
}


def net_of(mesh, levels):
    vertices, triangles = mesh
    return RefinedNet(cut_surface(triangles, len(vertices), NONE, NO_VERTEX), levels)


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_a_linear_function_stays_linear(name, levels):
    """Positions carried as values give flat triangles split evenly, by points and by corners."""
    vertices, triangles = CASES[name]
    net = net_of(CASES[name], levels)
    by_point = net.of_points(vertices)
    by_corner = net.of_corners(vertices[triangles.reshape(-1)])
    assert len(by_point) == net.n_vertices
    np.testing.assert_allclose(by_point[net.triangles.reshape(-1)], by_corner, atol=1e-14)
    assert np.array_equal(by_point[: len(vertices)], vertices)
    # The corners' barycentric coordinates, as brute force has them, in another order of children.
    centres = by_corner.reshape(len(triangles), 4**levels, 3, 3).mean(axis=2)
    expected = fine_barycentric(len(triangles), levels).mean(axis=1)
    expected = expected.reshape(4**levels, len(triangles), 3).swapaxes(0, 1)
    expected = np.einsum("fck,fkd->fcd", expected, vertices[triangles])
    for ours, theirs in zip(centres, expected, strict=True):
        gaps = np.linalg.norm(ours[:, None] - theirs, axis=2)
        assert gaps.min(axis=0).max() < 1e-12 and gaps.min(axis=1).max() < 1e-12


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_net_is_consistent(name, levels):
    """Sides are the edges of the triangles, orientation is the caller's, edges occur once."""
    vertices, triangles = CASES[name]
    net = net_of(CASES[name], levels)
    ends = np.sort(np.stack([net.triangles, net.triangles[:, [1, 2, 0]]], axis=2), axis=2)
    assert np.array_equal(ends, np.sort(net.edges, axis=1)[net.sides])
    assert len(np.unique(np.sort(net.edges, axis=1), axis=0)) == len(net.edges)
    flat = net.of_points(vertices)
    a, b, c = np.moveaxis(flat[net.triangles], 1, 0)
    fine = np.cross(b - a, c - a).reshape(-1, 4**levels, 3)
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    np.testing.assert_allclose(
        fine * 4**levels, np.repeat(np.cross(b - a, c - a)[:, None], 4**levels, 1), atol=1e-12
    )


@pytest.mark.parametrize("name", CASES)
def test_triangles_inherit(name):
    net = net_of(CASES[name], 2)
    numbers = np.arange(len(CASES[name][1]))
    assert np.array_equal(net.of_triangles(numbers), np.repeat(numbers, 16))


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_halves_inherit(name, levels):
    """Every part of an edge lies on it, straight; all other edges have the default."""
    vertices, triangles = CASES[name]
    net = net_of(CASES[name], levels)
    edges = meshes.edges_of(triangles).astype(np.int64)
    numbers = net.of_edges(np.arange(len(edges)), edges, -1)
    counts = np.bincount(numbers[numbers >= 0], minlength=len(edges))
    assert (counts == 2**levels).all()
    flat = net.of_points(vertices)
    on_edge = numbers >= 0
    a, b = vertices[edges[numbers[on_edge]]].swapaxes(0, 1)
    for point in flat[net.edges[on_edge]].swapaxes(0, 1):
        beside = np.linalg.norm(np.cross(point - a, b - a), axis=1)
        assert beside.max() < 1e-12
    # Edges that are not the triangles', such as diagonals that are no edges of the caller's.
    some = net.of_edges(np.ones(3, dtype=bool), edges[:3], False)
    assert some.sum() == 3 * 2**levels
    assert not net.of_edges(np.ones(0, dtype=bool), edges[:0], False).any()


def test_kinds_of_values():
    net = net_of(meshes.single_triangle(), 1)
    assert np.array_equal(net.of_points(np.array([True, True, False]))[3:], [True, False, False])
    whole = net.of_points(np.array([1, 3, 7], dtype=np.int32))
    assert whole.dtype == np.int32 and np.array_equal(whole[3:], [2, 5, 4])
    single = net.of_points(np.array([0.0, 1.0, 3.0], dtype=np.float32))
    assert single.dtype == np.float32 and np.array_equal(single[3:], [0.5, 2.0, 1.5])
    words = net.of_points(np.array(["a", "b", "c"], dtype=object))
    assert words.tolist()[:3] == ["a", "b", "c"] and set(words[3:]) <= {"a", "b", "c"}
