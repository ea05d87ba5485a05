"""Surfaces that are no manifold: cut to refine them, and whole again afterwards."""

import numpy as np
import pytest
from support import bad_meshes, meshes

from adaptive_fairing.core.surface.cut_surface import cut_surface
from adaptive_fairing.core.surface.limit_surface import LimitSurface

NONE = np.empty((0, 2), dtype=np.int64)
NO_VERTEX = np.empty(0, dtype=np.int64)
CASES = {
    name: getattr(bad_meshes, name)()
    for name in ("moebius_strip", "klein_bottle", "three_sheets", "bow_tie", "turned")
} | {"everything": bad_meshes.everything_wrong()}


def joined(mesh, levels, creases=NONE):
    """Return joined positions, triangles in the caller's orientation, and how far copies part."""
    vertices, triangles = mesh
    cut = cut_surface(triangles, len(vertices), creases, NO_VERTEX)
    refined = LimitSurface.from_levels(cut.levels, vertices[cut.vertex_of]).refined(levels)
    number = cut.joined_vertices(levels)
    positions = np.full((number.max() + 1, 3), np.nan)
    positions[number] = refined.vertices
    apart = np.abs(refined.vertices - positions[number]).max(axis=1)
    fine = number[refined.triangles]
    turned = np.repeat(cut.is_turned, 4**levels)
    fine[turned] = fine[turned, ::-1]
    return positions, fine, apart


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_what_was_joined_stays_joined(name, levels):
    """Copies of a vertex go to the same place, and the refined mesh has the same junctions."""
    vertices, triangles = CASES[name]
    positions, fine, apart = joined(CASES[name], levels)
    assert apart.max() <= 1e-12 * np.abs(vertices).max()
    assert np.isfinite(positions).all()
    cut = cut_surface(triangles, len(vertices), NONE, NO_VERTEX)
    kept = triangles[np.sort(cut.corner_of, axis=1)[:, 0] // 3]
    n_edges = len(meshes.edges_of(kept))
    assert len(meshes.edges_of(fine)) == 2**levels * n_edges + 3 * len(kept) * (
        2 ** (levels - 1) * (2**levels - 1)
    )
    # The caller's vertices keep their numbers: each is still a corner of as many triangles.
    corners = np.bincount(fine.reshape(-1), minlength=len(positions))[: len(vertices)]
    assert np.array_equal(corners, np.bincount(kept.reshape(-1), minlength=len(vertices)))


def test_orientation_is_the_callers():
    vertices, triangles = bad_meshes.turned()
    whole = joined(meshes.random_closed(1), 1)
    positions, fine, _ = joined((vertices, triangles), 1)
    assert len(fine) == 4 * len(triangles)
    a, b, c = np.moveaxis(positions[fine], 1, 0)
    normals = np.cross(b - a, c - a).reshape(-1, 4, 3)
    a, b, c = np.moveaxis(whole[0][whole[1]], 1, 0)
    expected = np.cross(b - a, c - a).reshape(-1, 4, 3)
    was_turned = (triangles != meshes.random_closed(1)[1]).any(axis=1)
    signs = np.sign(np.einsum("fcd,fcd->fc", normals, expected.sum(axis=1, keepdims=True)))
    assert np.array_equal(signs[:, 3] < 0, was_turned)


def test_curves_of_cuts_are_splines():
    """The spine of three sheets is an edge of more than two triangles: a straight line, kept."""
    positions, fine, _ = joined(bad_meshes.three_sheets(), 2)
    on_spine = (np.abs(positions[:, 1:]) < 1e-12).all(axis=1)
    assert np.count_nonzero(on_spine) == 3 * 4 + 1
    edges = np.sort(fine[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, n_triangles = np.unique(edges[on_spine[edges].all(axis=1)], axis=0, return_counts=True)
    assert (n_triangles == 3).all() and len(n_triangles) == 12


def test_manifold_meshes_are_not_touched():
    vertices, triangles = meshes.bumpy_disc(0)
    cut = cut_surface(triangles, len(vertices), NONE, NO_VERTEX)
    assert not cut.is_cut and cut.notes == ()
    assert np.array_equal(cut.joined_vertices(1), np.arange(cut.levels.mesh(1).n_vertices))


def test_creases_that_no_triangle_has_are_ignored():
    vertices, triangles = meshes.flat_grid(2, 2)
    inner_edge = np.sort(meshes.edges_of(triangles), axis=1)[
        ~np.isin(meshes.edges_of(triangles), meshes.boundary_vertices(triangles)).all(axis=1)
    ][0]
    cut = cut_surface(
        triangles, len(vertices) + 2, np.array([(9, 10), tuple(inner_edge), (0, 8)]), NO_VERTEX
    )
    mesh = cut.levels.mesh(0)
    inner = mesh.is_sharp & (mesh.right >= 0)
    assert np.array_equal(np.sort(mesh.edges[inner], axis=1), [inner_edge])


def test_creases_across_cuts():
    """Where creases meet the junction of sheets, all copies are corners and stay together."""
    vertices, triangles = bad_meshes.three_sheets()
    rng = np.random.default_rng(2)
    edges = meshes.edges_of(triangles)
    creases = edges[rng.random(len(edges)) < 0.3].astype(np.int64)
    _, _, apart = joined((vertices, triangles), 2, creases)
    assert apart.max() < 1e-14
