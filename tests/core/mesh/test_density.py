"""The density d_i and its smoothing (3.6)."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import FairingError, TriangleTopology, mesh_density

MESHES = [
    pytest.param(meshes.random_closed(1), id="closed"),
    pytest.param(meshes.bumpy_disc(0), id="open"),
]


def topology_of(mesh):
    return TriangleTopology(mesh[1], len(mesh[0]))


def neighbours(mesh):
    sets = [set() for _ in mesh[0]]
    for a, b in meshes.edges_of(mesh[1]).tolist():
        sets[a].add(b)
        sets[b].add(a)
    return [sorted(s) for s in sets]


@pytest.mark.parametrize("mesh", MESHES)
def test_edge_density_is_the_mean_distance_to_the_neighbours(mesh):
    vertices = mesh[0]
    expected = [
        np.linalg.norm(vertices[around] - vertices[i], axis=1).mean()
        for i, around in enumerate(neighbours(mesh))
    ]
    density = mesh_density(topology_of(mesh), vertices, smoothing_passes=0)
    np.testing.assert_allclose(density, expected, rtol=1e-13)


@pytest.mark.parametrize("mesh", MESHES)
def test_area_density_is_the_sum_of_the_areas_around(mesh):
    vertices, faces = mesh
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    expected = [areas[(faces == i).any(axis=1)].sum() for i in range(len(vertices))]
    density = mesh_density(topology_of(mesh), vertices, "area", smoothing_passes=0)
    np.testing.assert_allclose(density, expected, rtol=1e-12)


@pytest.mark.parametrize("kind", ["edge_length", "area"])
@pytest.mark.parametrize("mesh", MESHES)
def test_each_pass_applies_the_rule_3_6(mesh, kind):
    """(1 - n l) d_i + l sum d_j, l = 1 / (n + 3 / (8 a)); (1/6, 2/3, 1/6) on the boundary."""
    vertices, faces = mesh
    border = set(meshes.boundary_vertices(faces).tolist())
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    known = {tuple(side) for side in sides.tolist()}
    density = mesh_density(topology_of(mesh), vertices, kind, smoothing_passes=0)
    for passes in (1, 2, 3):
        smoothed = np.empty_like(density)
        for i, around in enumerate(neighbours(mesh)):
            if i in border:
                along = [j for j in around if ((i, j) in known) != ((j, i) in known)]
                assert len(along) == 2
                smoothed[i] = 2 / 3 * density[i] + density[along].sum() / 6
                continue
            n = len(around)
            a = (5 / 8 - (3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2) / n
            weight = 1 / (n + 3 / (8 * a))
            smoothed[i] = (1 - n * weight) * density[i] + weight * density[around].sum()
        density = smoothed
        np.testing.assert_allclose(
            mesh_density(topology_of(mesh), vertices, kind, passes), density, rtol=1e-12
        )


def test_density_scales_as_a_length_or_an_area():
    mesh = meshes.random_closed(1)
    for kind, factor in (("edge_length", 3), ("area", 9)):
        plain = mesh_density(topology_of(mesh), mesh[0], kind)
        np.testing.assert_allclose(
            mesh_density(topology_of(mesh), 3 * mesh[0], kind), factor * plain, rtol=1e-12
        )


def test_density_follows_a_grading_of_16():
    vertices, faces = meshes.graded_sphere(4)
    density = mesh_density(TriangleTopology(faces, len(vertices)), vertices)
    assert 14 < density.max() / density.min() < 18


def test_passes_even_out_the_density():
    mesh = meshes.random_closed(1)
    spreads = [
        np.std(mesh_density(topology_of(mesh), mesh[0], smoothing_passes=n)) for n in (0, 1, 3, 10)
    ]
    assert spreads == sorted(spreads, reverse=True)


def test_loose_vertices_have_density_zero():
    vertices, faces = meshes.octahedron()
    topology = TriangleTopology(faces, 7)
    for kind in ("edge_length", "area"):
        density = mesh_density(topology, np.vstack([vertices, [(5.0, 5, 5)]]), kind)
        assert density[6] == 0
        np.testing.assert_allclose(density[:6], density[0], rtol=1e-12)


def test_unknown_kind_is_refused_by_name():
    mesh = meshes.octahedron()
    with pytest.raises(FairingError, match=r"density.*edge_length.*area.*'size'"):
        mesh_density(topology_of(mesh), mesh[0], "size")
