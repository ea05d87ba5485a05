"""The last refinement is kept, and is taken again for the same mesh only."""

import numpy as np
import pytest
from support.meshes import icosphere

from adaptive_fairing.blender.data import refinement_cache
from adaptive_fairing.blender.data.refinement_cache import refinement_of
from adaptive_fairing.core import LimitSurface, TriangleTopology

NO_CREASES, NONE_HELD = np.empty((0, 2), dtype=np.int64), np.empty(0, dtype=np.int64)


@pytest.fixture(autouse=True)
def _nothing_kept():
    refinement_cache.forget()
    yield
    refinement_cache.forget()


@pytest.fixture
def ball():
    return icosphere(1)


def refinement(ball, creases=NO_CREASES, held=NONE_HELD):
    vertices, triangles = ball
    return refinement_of(triangles.astype(np.int32), len(vertices), creases, held, levels=1)


def test_the_same_mesh_gets_the_same_one(ball):
    assert refinement(ball) is refinement(ball)


def test_other_creases_held_vertices_or_triangles_get_another(ball):
    vertices, triangles = ball
    first = refinement(ball)
    assert refinement(ball, creases=triangles[:1, :2].astype(np.int64)) is not first
    first = refinement(ball)
    assert refinement(ball, held=np.array([3])) is not first
    first = refinement(ball)
    assert refinement((vertices, triangles[::-1])) is not first


def test_one_that_takes_too_much_memory_is_not_kept(ball, monkeypatch):
    monkeypatch.setattr(refinement_cache, "LARGEST_KEPT", 4 * len(ball[1]) - 1)
    assert refinement(ball) is not refinement(ball)


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_shapes_on_the_limit_are_those_of_the_core(ball, levels):
    vertices, triangles = ball
    limit = LimitSurface(TriangleTopology(triangles, len(vertices)), vertices).refined(levels)
    kept = refinement(ball)
    shape = kept.shape(vertices, levels, on_limit=True, has_normals=True)
    np.testing.assert_allclose(shape.positions, limit.vertices, atol=1e-6)
    np.testing.assert_allclose(shape.normals, limit.normals, atol=1e-12)
    np.testing.assert_array_equal(kept.net(levels).triangles, limit.triangles)


def test_a_shape_with_normals_is_kept_until_the_positions_change(ball):
    vertices, _ = ball
    kept = refinement(ball)
    first = kept.shape(vertices, 1, on_limit=True, has_normals=True)
    assert kept.shape(vertices.copy(), 1, on_limit=True, has_normals=True) is first
    moved = kept.shape(2 * vertices, 1, on_limit=True, has_normals=True)
    np.testing.assert_allclose(moved.positions, 2 * first.positions, rtol=1e-6)
