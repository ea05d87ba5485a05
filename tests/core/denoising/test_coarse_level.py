"""Coarse levels: seeds that are apart, a mesh of the same kind, fields carried back."""

import numpy as np
import pytest
from scipy.sparse import csgraph
from support.meshes import flat_grid, icosphere, merged, random_closed, torus

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.coarse_level import CoarseLevel, most_hops
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface


def surface_of(mesh):
    vertices, faces = mesh
    return TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)


def euler(topology):
    used = np.count_nonzero(~topology.is_loose)
    n_edges = (3 * topology.n_triangles + np.count_nonzero(topology.twin < 0)) // 2
    return used - n_edges + topology.n_triangles


@pytest.mark.parametrize("hops", [1, 2, 4])
@pytest.mark.parametrize("mesh", [icosphere(4), flat_grid(40, 50), random_closed(3, icosphere(3))])
def test_seeds_are_apart_and_leave_no_room(mesh, hops):
    fine = surface_of(mesh)
    level = CoarseLevel.over(fine, hops)
    edges = csgraph.dijkstra(fine.topology.adjacency(), indices=level.seeds, unweighted=True)
    between = edges[:, level.seeds]
    assert between[~np.eye(len(between), dtype=bool)].min() > hops
    assert edges.min(axis=0).max() <= hops
    assert (level.cell[level.seeds] == np.arange(len(level.seeds))).all()


@pytest.mark.parametrize("hops", [1, 2, 4])
@pytest.mark.parametrize(("mesh", "characteristic"), [(icosphere(5), 2), (torus(90, 40), 0)])
def test_a_closed_surface_stays_closed_of_its_kind_and_facing_its_way(mesh, characteristic, hops):
    fine = surface_of(mesh)
    level = CoarseLevel.over(fine, hops)
    assert level.topology.is_closed
    assert euler(level.topology) == characteristic
    assert level.is_known.all()
    own = TriangleSurface(level.topology, fine.positions[level.vertices])
    cosines = np.einsum("nd,nd->n", own.normals, fine.normals[level.vertices])
    assert cosines.min() > 0.5


@pytest.mark.parametrize("hops", [1, 2, 3, 4])
def test_edges_span_as_many_as_they_should(hops):
    ratio = CoarseLevel.over(surface_of(icosphere(5)), hops).ratio
    assert most_hops(1.06 * ratio) == hops
    assert most_hops(0.94 * ratio) == hops - 1


def test_pieces_stay_apart_and_loose_vertices_are_left_out():
    vertices, faces = merged(icosphere(3), icosphere(3))
    vertices[len(vertices) // 2 :] += 5
    vertices = np.vstack([vertices, [[9.0, 9.0, 9.0]]])
    fine = surface_of((vertices, faces))
    level = CoarseLevel.over(fine, 1)
    assert euler(level.topology) == 4
    assert level.cell[-1] == -1
    assert len(vertices) - 1 not in level.seeds


def test_the_numbering_of_the_vertices_plays_no_part():
    vertices, faces = random_closed(5, icosphere(4))
    order = np.random.default_rng(0).permutation(len(vertices))
    place = np.argsort(order)
    one = CoarseLevel.over(surface_of((vertices, faces)), 2)
    other = CoarseLevel.over(surface_of((vertices[order], place[faces])), 2)
    assert set(order[other.seeds]) == set(one.seeds)


def test_constant_heights_come_back_constant_and_smooth_ones_nearly():
    fine = surface_of(icosphere(5))
    level = CoarseLevel.over(fine, 2)
    smooth = fine.positions[:, 0] * fine.positions[:, 1]
    heights = np.stack([np.ones(len(level.vertices)), smooth[level.vertices]], axis=1)
    field = level.carried_back(heights, fine)
    assert np.abs(field[:, 0] - 1).max() < 1e-9
    assert np.abs(field[:, 1] - smooth).max() < 0.03 * np.abs(smooth).max()


def test_cells_of_which_nothing_is_known_follow_their_neighbours():
    # A boundary pinched to one vertex cannot be kept: the level is cut there.
    fine = surface_of(flat_grid(30, 30))
    level = CoarseLevel.over(fine, 2)
    vars(level)["is_known"] = np.arange(len(level.vertices)) % 7 != 0
    field = level.carried_back(np.ones((len(level.vertices), 1)), fine)
    assert np.abs(field - 1).max() < 0.1
