"""`keep_volume`: every closed part has its volume after every step."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import FairingSettings, TriangleTopology, fair
from adaptive_fairing.core.mesh.normals import vertex_normals

METHODS = ("uniform", "adaptive_timestep", "adaptive_tensor")
PROMISED = 1e-6


def volume(vertices, faces):
    """Volume within triangles."""
    return np.linalg.det(vertices[faces]).sum() / 6


def together(*parts):
    """One mesh of several, and the slice of vertices of each."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = np.concatenate([f + start for (_, f), start in zip(parts, starts, strict=False)])
    slices = [slice(first, last) for first, last in pairwise(starts)]
    return np.concatenate([vertices for vertices, _ in parts]), faces, slices


@pytest.mark.parametrize("method", METHODS)
def test_a_closed_surface_keeps_its_volume_in_every_step(method):
    mesh = meshes.noisy_ball(2, 0.05)
    shrinking = fair(*mesh, FairingSettings(method=method, radius=1.0))
    assert volume(shrinking.positions, mesh[1]) < 0.95 * volume(*mesh)
    kept = fair(*mesh, FairingSettings(method=method, radius=1.0, keep_volume=True))
    for step in kept.steps:
        assert volume(step.positions, mesh[1]) == pytest.approx(volume(*mesh), rel=PROMISED)
        # That within the limit surface follows.
        assert step.volume == pytest.approx(kept.initial.volume, rel=1e-2)
    # It is as smooth as without: only the size is another.
    assert kept.steps[-1].curvature_ratio == pytest.approx(
        shrinking.steps[-1].curvature_ratio, rel=0.02
    )


def test_every_part_keeps_its_own():
    ball = meshes.noisy_ball(2, 0.05)
    small = 0.3 * meshes.noisy_ball(1, 0.1)[0] + 3, meshes.noisy_ball(1)[1]
    inside_out = meshes.noisy_ball(2, 0.03)[0] - 4, ball[1][:, ::-1]
    vertices, faces, parts = together(ball, small, inside_out)
    faired = fair(vertices, faces, FairingSettings(radius=1.0, keep_volume=True)).positions
    for part, (before, own) in zip(parts, (ball, small, inside_out), strict=True):
        assert volume(faired[part], own) == pytest.approx(volume(before, own), rel=PROMISED)


def test_open_parts_are_left_alone_and_said_so():
    disc, ball = meshes.bumpy_disc(0), (meshes.noisy_ball(2, 0.05)[0] + 5, meshes.icosphere(2)[1])
    vertices, faces, (open_part, closed) = together(disc, ball)
    plain, kept = (
        fair(vertices, faces, FairingSettings(radius=1.0, keep_volume=keep, cg_tolerance=1e-12))
        for keep in (False, True)
    )
    np.testing.assert_allclose(
        kept.steps[0].positions[open_part], plain.steps[0].positions[open_part], atol=1e-10
    )
    assert volume(kept.positions[closed], ball[1]) == pytest.approx(volume(*ball), rel=PROMISED)
    assert any("1 part is open and has no volume to keep" in note for note in kept.notes)
    assert not any("volume" in note for note in plain.notes)


def test_weights_say_who_moves():
    vertices, faces = meshes.noisy_ball(2, 0.05)
    weights = np.clip(vertices[:, 2] + 0.5, 0, 1)
    settings = FairingSettings(radius=1.0, keep_volume=True, steps=2)
    kept = fair(vertices, faces, settings, weights=weights)
    held = weights == 0
    assert 20 < held.sum() < 100
    for step in kept.steps:
        assert np.array_equal(step.positions[held], vertices[held])
        assert volume(step.positions, faces) == pytest.approx(volume(vertices, faces), rel=PROMISED)


@pytest.mark.parametrize("method", METHODS)
def test_what_is_added_to_a_step_goes_along_the_normals_by_the_local_times(method):
    vertices, faces = meshes.graded_sphere(2, 1.5)
    weights = np.random.default_rng(1).uniform(size=len(vertices))
    settings = FairingSettings(method=method, steps=1, radius=1.0, cg_tolerance=1e-12)
    plain, kept = (
        fair(vertices, faces, replace(settings, keep_volume=keep), weights=weights).steps[0]
        for keep in (False, True)
    )
    times = weights if method == "uniform" else weights * plain.density
    plain, kept = plain.positions, kept.positions
    normals = vertex_normals(TriangleTopology(faces, len(vertices)), plain)
    offset = np.einsum("id,id->i", kept - plain, normals) / times
    np.testing.assert_allclose(offset, offset.mean(), rtol=1e-6)
    assert (offset * times).max() > 0.01
    np.testing.assert_allclose(kept - plain, offset.mean() * times[:, None] * normals, atol=1e-8)


@pytest.mark.parametrize("density", ["area", "edge_length"])
def test_a_thin_part_with_a_dense_mesh_does_not_fold(density):
    vertices, faces = meshes.graded_sphere(3, 6.0)
    vertices[:, 2] += 0.5 * np.clip((vertices[:, 2] - 0.97) / 0.03, 0, 1)  # a thorn
    settings = FairingSettings(radius=1.0, density=density)
    plain, kept = (
        fair(vertices, faces, replace(settings, keep_volume=keep)) for keep in (False, True)
    )
    assert volume(kept.positions, faces) == pytest.approx(volume(vertices, faces), rel=PROMISED)
    for without, step in zip(plain.steps, kept.steps, strict=True):
        assert step.curvature_ratio < 1.05 * without.curvature_ratio < 1.05


def test_a_largest_deviation_that_costs_volume_is_said():
    vertices, faces = meshes.noisy_ball(2, 0.05)
    settings = FairingSettings(radius=1.0, keep_volume=True, max_deviation=0.01)
    bound = fair(vertices, faces, settings)
    assert volume(bound.positions, faces) != pytest.approx(volume(vertices, faces), rel=PROMISED)
    (note,) = bound.notes
    n_far = (np.linalg.norm(bound.positions - vertices, axis=1) > 0.01 * (1 - 1e-9)).sum()
    assert note == (
        f"the volume is not kept exactly: the largest deviation held {n_far} vertices back"
    )
    assert not fair(vertices, faces, replace(settings, max_deviation=1.0)).notes
    assert not fair(vertices, faces, replace(settings, keep_volume=False)).notes


def test_a_sphere_stays_the_sphere_that_it_is():
    vertices, faces = meshes.icosphere(3)
    kept = fair(vertices, faces, FairingSettings(radius=2.0, keep_volume=True)).positions
    np.testing.assert_allclose(np.linalg.norm(kept, axis=1), 1.0, atol=2e-3)


def test_far_from_the_origin_it_is_as_exact():
    vertices, faces = meshes.noisy_ball(2, 0.05)
    vertices = vertices + 1e6
    kept = fair(vertices, faces, FairingSettings(keep_volume=True)).positions
    before, after = (volume(each - 1e6, faces) for each in (vertices, kept))
    assert after == pytest.approx(before, rel=PROMISED)


def test_a_part_that_collapses_is_said_so_and_moved_no_further():
    vertices, faces = meshes.icosphere(1)
    settings = FairingSettings(method="uniform", tau=1e8, steps=1, keep_volume=True)
    result = fair(vertices, faces, settings)
    assert np.isfinite(result.positions).all()
    assert np.abs(result.positions).max() <= 2
    kept = volume(result.positions, faces) == pytest.approx(volume(vertices, faces), rel=PROMISED)
    assert kept != any("1 closed part has collapsed" in note for note in result.notes)


def test_nothing_to_move_and_no_volume_are_no_error():
    vertices, faces = meshes.icosphere(1)
    settings = FairingSettings(keep_volume=True, steps=2)
    held = fair(vertices, faces, settings, weights=np.zeros(len(vertices)))
    assert np.array_equal(held.positions, vertices)
    flat = fair(vertices * (1, 1, 0), faces, settings)
    assert np.isfinite(flat.positions).all()
