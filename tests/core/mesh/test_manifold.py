"""Cutting bad connectivity into an oriented manifold: each fault has its rule."""

import numpy as np
import pytest
from support.bad_meshes import (
    bow_tie,
    everything_wrong,
    klein_bottle,
    moebius_strip,
    three_sheets,
    turned,
)
from support.meshes import boundary_vertices, flat_grid, icosphere, random_closed, tetrahedron

from adaptive_fairing.core import TopologyError, TriangleTopology
from adaptive_fairing.core.mesh.manifold import cut_to_manifold


def cut(mesh):
    """Cut a mesh and check what holds for every one: an oriented manifold, no vertex lost."""
    vertices, faces = mesh
    before = faces.copy()
    result = cut_to_manifold(faces, len(vertices))
    np.testing.assert_array_equal(faces, before)
    topology = TriangleTopology(result.triangles, len(result.vertex_of))
    np.testing.assert_array_equal(np.unique(result.vertex_of), np.arange(len(vertices)))
    # The same triangles over the caller's vertices, up to their orientation.
    kept = np.delete(np.arange(len(faces)), result.left_out)
    np.testing.assert_array_equal(
        np.sort(result.vertex_of[result.triangles], axis=1), np.sort(faces[kept], axis=1)
    )
    # Pieces stay together: a vertex with several copies is held, in all of them.
    copies = np.bincount(result.vertex_of)[result.vertex_of]
    assert result.is_held[copies > 1].all()
    return result, topology


def held_vertices(result):
    return np.unique(result.vertex_of[result.is_held]).tolist()


def test_a_manifold_is_left_as_it_is():
    vertices, faces = random_closed(seed=3)
    result, topology = cut((vertices, faces))
    assert topology.is_closed
    np.testing.assert_array_equal(result.vertex_of[result.triangles], faces)
    assert (result.notes, held_vertices(result), len(result.left_out)) == ((), [], 0)


def test_triangles_with_a_repeated_vertex_are_left_out():
    vertices, faces = tetrahedron()
    bad = np.vstack([[(1, 1, 2)], faces, [(3, 3, 3)]]).astype(np.int32)
    result, topology = cut((vertices, bad))
    assert topology.is_closed
    assert result.left_out.tolist() == [0, 5]
    assert result.notes == ("2 triangles use one vertex twice: left out",)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 0, 2)])
def test_the_later_of_equal_triangles_is_left_out(order):
    vertices, faces = tetrahedron()
    result, topology = cut((vertices, np.vstack([faces, faces[2:3, list(order)]])))
    assert topology.is_closed
    assert result.left_out.tolist() == [4]
    assert result.notes == ("1 triangles repeat the vertices of another one: left out",)


def test_surfaces_are_cut_along_edges_of_more_than_two_triangles():
    n = 3
    vertices, faces = three_sheets(n)
    result, topology = cut((vertices, faces))
    spine = np.flatnonzero((vertices[:, 1:] == 0).all(axis=1))
    assert held_vertices(result) == spine.tolist()
    assert len(result.vertex_of) == 3 * (n + 1) ** 2
    assert result.notes == ("3 edges have more than two triangles: cut there, their vertices held",)
    assert topology.on_boundary[result.is_held].all()


def test_orientation_is_made_consistent_at_the_expense_of_the_smaller_part():
    vertices, faces = random_closed(seed=1)
    result, topology = cut(turned(seed=1, share=0.3))
    assert topology.is_closed
    # More than half of the triangles were right, so all come out as they were made.
    volume = np.linalg.det(vertices[result.vertex_of[result.triangles]]).sum()
    assert volume == pytest.approx(np.linalg.det(vertices[faces]).sum(), rel=1e-12)
    n_turned = int((turned(seed=1, share=0.3)[1] != faces).any(axis=1).sum())
    assert result.notes == (f"{n_turned} triangles were turned round, for the solve only",)


def test_inward_orientation_is_no_fault():
    vertices, faces = tetrahedron()
    result, _ = cut((vertices, faces[:, ::-1]))
    np.testing.assert_array_equal(result.vertex_of[result.triangles], faces[:, ::-1])
    assert result.notes == ()


def test_a_moebius_strip_is_torn_across_once():
    vertices, faces = moebius_strip(8)
    result, topology = cut((vertices, faces))
    assert len(held_vertices(result)) == 2
    assert len(result.vertex_of) == len(vertices) + 2
    assert "1 edges of one-sided pieces: cut there, their vertices held" in result.notes
    # Torn once it is an ordinary strip: a disc.
    n_edges = (3 * len(faces) + np.count_nonzero(topology.twin < 0)) // 2
    assert len(result.vertex_of) - n_edges + len(faces) == 1


def test_a_closed_surface_with_one_side_is_torn_as_little_as_needed():
    vertices, faces = klein_bottle(6)
    result, topology = cut((vertices, faces))
    assert not topology.is_closed
    assert 0 < len(held_vertices(result)) < len(vertices) / 2


def test_surfaces_that_touch_in_a_vertex_are_cut_apart_there():
    vertices, faces = bow_tie()
    result, topology = cut((vertices, faces))
    assert topology.is_closed
    assert held_vertices(result) == [0]
    assert np.count_nonzero(result.vertex_of == 0) == 2
    assert result.notes == ("1 vertices join surfaces in a single point: cut there and held",)


def test_open_fans_that_touch_in_a_vertex_are_cut_apart_there():
    faces = np.array([(0, 1, 2), (0, 3, 4)], dtype=np.int32)
    result, _ = cut((np.zeros((5, 3)), faces))
    assert held_vertices(result) == [0]


def test_two_triangles_back_to_back_become_one():
    faces = np.array([(0, 1, 2), (2, 1, 0)], dtype=np.int32)
    result, topology = cut((np.zeros((3, 3)), faces))
    assert topology.n_triangles == 1
    assert result.left_out.tolist() == [1]


def test_loose_vertices_stay_in_the_numbering():
    vertices, faces = icosphere(1)
    result, topology = cut((np.vstack([[(5, 5, 5)], vertices, [(6, 6, 6)]]), faces + 1))
    assert (
        np.flatnonzero(topology.is_loose).tolist()
        == np.flatnonzero(np.isin(result.vertex_of, [0, len(vertices) + 1])).tolist()
    )


def test_everything_wrong_at_once():
    result, _ = cut(everything_wrong())
    assert len(result.notes) == 6


def test_random_triangles_always_become_a_manifold():
    for seed in range(300):
        generator = np.random.default_rng(seed)
        n_vertices = int(generator.integers(3, 10))
        faces = generator.integers(0, n_vertices, (int(generator.integers(1, 40)), 3))
        cut((np.zeros((n_vertices, 3)), faces.astype(np.int32)))


@pytest.mark.parametrize(
    ("faces", "message", "culprits"),
    [
        ([(0, 1, 1)], "1 triangles use one vertex twice: triangles 0", {"triangles": [0]}),
        (
            [(0, 1, 2), (1, 0, 3), (0, 1, 4)],
            "1 non-manifold edges, shared by more than two triangles: (0, 1)",
            {"edges": [[0, 1]]},
        ),
        (
            [(0, 1, 2), (0, 1, 3)],
            "1 edges whose two triangles have opposite orientation: (0, 1)",
            {"edges": [[0, 1]]},
        ),
        (
            [(0, 1, 2), (0, 3, 4)],
            "1 non-manifold vertices, where surfaces touch in a single point: 0",
            {"vertices": [0]},
        ),
        (
            [(0, 1, 2), (2, 1, 0)],
            "3 closed vertices of valence 2 (two triangles back to back): 0, 1, 2",
            {"vertices": [0, 1, 2]},
        ),
    ],
)
def test_the_topology_itself_refuses_with_names(faces, message, culprits):
    with pytest.raises(TopologyError) as error:
        TriangleTopology(faces, 5)
    assert str(error.value).startswith(message)
    for name in ("vertices", "edges", "triangles"):
        assert getattr(error.value, name).tolist() == culprits.get(name, [])


def test_flat_pieces_keep_their_boundary():
    vertices, faces = flat_grid(3, 4)
    result, topology = cut((vertices, faces))
    on_boundary = np.unique(result.vertex_of[topology.on_boundary])
    np.testing.assert_array_equal(on_boundary, boundary_vertices(faces))
