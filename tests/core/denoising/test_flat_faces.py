"""Flat faces, found up to their creases and made flat, beside round shapes, which stay."""

from dataclasses import replace

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology, denoise
from adaptive_fairing.core.denoising.flat_faces import FlatFaces, best_of_triangles
from adaptive_fairing.core.denoising.noise_model import FADING
from adaptive_fairing.core.denoising.parameters import PARAMETERS, using
from adaptive_fairing.core.denoising.plan import STRENGTHS
from adaptive_fairing.core.denoising.plane_fits import PlaneFits
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface


def bent_sheet(radius):
    """A sheet of edge length 1 that is bent down along a quarter of a cylinder, and where it is."""
    flat, faces = meshes.flat_grid(60, 24)
    way, y = flat[:, 0] - 24, flat[:, 1]
    angle = np.clip(way / radius, 0, np.pi / 2)
    before, after = np.minimum(way, 0), np.maximum(way - radius * np.pi / 2, 0)
    x = before + radius * np.sin(angle)
    z = radius * (np.cos(angle) - 1) - after
    return np.stack([x, y, z], axis=1), faces, (angle > 0) & (angle < np.pi / 2)


CUBE, FACES = meshes.cube(4, unevenness=0.2)
EDGE = 2 / 16


def noisy_cube(amplitude, seed=0):
    """Noise along the directions from the middle, in edge lengths."""
    outward = CUBE / np.linalg.norm(CUBE, axis=1, keepdims=True)
    height = np.random.default_rng(seed).normal(0, amplitude * EDGE, (len(CUBE), 1))
    return CUBE + height * outward


def flat_faces(positions, faces, surface, noise=0.2):
    """The flat faces of a surface, with noise in edge lengths that is the same everywhere."""
    topology = TriangleTopology(faces, len(positions))
    return FlatFaces(TriangleSurface(topology, surface), positions, np.full(len(positions), noise))


def flattened(positions, faces, surface, noise=0.2):
    """The surface after its flat faces were made flat."""
    return flat_faces(positions, faces, surface, noise).flattened(positions, surface)


def off_the_cube(positions):
    """Distance of the vertices from the planes of the faces they belong to, largest first."""
    on_face = np.isclose(np.abs(CUBE), 1)
    return np.where(on_face, np.abs(np.abs(positions) - 1), 0).max(axis=1)


def test_the_faces_of_a_cube_end_at_its_creases():
    found = flat_faces(noisy_cube(0.2), FACES, noisy_cube(0.04, seed=1))
    # Faces of the clean cube: the axis and side that all corners of a triangle are on.
    corners = CUBE[FACES]
    sides = [np.isclose(corners[:, :, k], s).all(axis=1) for k in range(3) for s in (-1, 1)]
    true_face = np.argmax(sides, axis=0)
    assert found.face.min() == 0
    assert len(np.unique(np.stack([true_face, found.face]), axis=1).T) == 6


def test_vertices_lie_on_the_planes_of_their_faces():
    """Planes of n = 289 vertices are as exact as √(3 / n) of the noise, 0.2 of an edge."""
    result = flattened(noisy_cube(0.2), FACES, noisy_cube(0.04, seed=1))
    error = np.sqrt(np.mean(off_the_cube(result) ** 2)) / EDGE
    assert error < 2 * 0.2 * np.sqrt(3 / 289)


@pytest.mark.parametrize("shape", [meshes.icosphere(4), meshes.torus(60, 30)])
def test_round_shapes_stay(shape):
    points, faces = shape
    assert flattened(points, faces, points, PARAMETERS.clean_roughness) is points


@pytest.mark.parametrize("noise", [0.1, 0.2, 0.4])
def test_pieces_of_a_noisy_ball_are_no_faces(noise):
    points, faces = meshes.icosphere(4)
    edge = np.linalg.norm(points[faces[:, 0]] - points[faces[:, 1]], axis=1).mean()
    heights = np.random.default_rng(0).normal(0, noise * edge, (len(points), 1))
    # A tenth of the noise is left in the surface.
    noisy, surface = points * (1 + heights), points * (1 + 0.1 * heights)
    assert flattened(noisy, faces, surface, noise) is surface


@pytest.mark.parametrize("radius", [6, 12])
def test_a_rounded_edge_keeps_its_shape_between_flat_faces(radius):
    points, faces, is_round = bent_sheet(radius)
    noise = np.random.default_rng(0).normal(0, 0.1, points.shape)
    found = flat_faces(points + noise, faces, points, 0.1)
    moved = np.linalg.norm(found.flattened(points + noise, points) - points, axis=1)
    assert len(np.unique(found.face)) == 3  # with what is on no face
    # Faces reach over what is nearer to their planes than `face_height`: a strip on either side.
    strip = np.sqrt(2 * PARAMETERS.face_height * radius) + 1
    assert np.mean(moved[is_round] > 0) < 2 * strip / (radius * np.pi / 2)
    assert moved[is_round].max() < PARAMETERS.face_height + 0.1
    assert moved[~is_round].max() < 0.1


def test_a_face_counts_the_less_the_more_it_is_bent(monkeypatch):
    """Without a jump up to the limit, and beyond it not at all: rounding must not decide."""
    points, faces, _ = bent_sheet(12)
    noisy = points + np.random.default_rng(0).normal(0, 0.1, points.shape)
    ways, bends = [], np.linspace(0.6, 1.05, 46)
    # Bent faces are not to be too few as well.
    with using(replace(PARAMETERS, least_flat=1e-6)):
        for bend in bends:
            monkeypatch.setattr(PlaneFits, "bends", lambda fits, _, b=bend: np.full(len(fits), b))
            found = flat_faces(noisy, faces, points, 0.1)
            ways.append(found.flattened(noisy, points) - points)
    steps = np.linalg.norm(np.diff(ways, axis=0), axis=2).max(axis=1)
    most = np.linalg.norm(ways, axis=2).max()
    assert not steps[bends[1:] <= 1 - 1 / FADING].any()
    assert not steps[bends[:-1] >= 1].any()
    assert 0 < steps.max() < 2 * FADING * (bends[1] - bends[0]) * most


def test_a_vertex_belongs_as_far_as_the_lowest_corner_of_its_best_triangle():
    values = np.random.default_rng(0).random(len(CUBE))
    shares = np.random.default_rng(1).random(len(FACES))
    lowest = shares * values[FACES].min(axis=1)
    of_each = [lowest[(FACES == vertex).any(axis=1)].max() for vertex in range(len(CUBE))]
    assert np.array_equal(best_of_triangles(values, FACES, shares), of_each)


def test_a_triangle_that_changes_sides_moves_its_vertices_gradually():
    """The ridge of a flat roof passes under triangles that are nearly as near to either side."""
    flat, faces = meshes.flat_grid(24, 24)
    heights = 0.05 * np.random.default_rng(1).normal(size=len(flat))
    ways = []
    for ridge in np.linspace(11, 12, 101):
        roof = -0.3 * np.abs(flat[:, 0] - ridge)
        noisy, smooth = (np.column_stack([flat[:, :2], roof + part * heights]) for part in (1, 0.5))
        found = flat_faces(noisy, faces, smooth, 0.05)
        assert set(found.face) >= {0, 1}
        ways.append(found.flattened(noisy, smooth) - smooth)
    steps = np.linalg.norm(np.diff(ways, axis=0), axis=2)
    assert 0 < steps.max() < 0.5 * np.linalg.norm(ways, axis=2).max()


def test_an_open_noisy_sheet_becomes_flat():
    flat, faces = meshes.flat_grid(24, 24)
    heights = np.random.default_rng(0).normal(0, 0.2, len(flat))
    sheet = flat + np.outer(heights, [0, 0, 1])
    rough = flat + 0.2 * np.outer(heights, [0, 0, 1])
    result = flattened(sheet, faces, rough)
    offset = result - result.mean(axis=0)
    assert np.linalg.svd(offset)[1][2] < 1e-2 * np.sqrt(len(flat))


def test_a_vertex_that_rises_out_of_a_face_leaves_it_gradually():
    """What it moves follows its height without a jump: rounding must not decide."""
    flat, faces = meshes.flat_grid(24, 24)
    middle = np.argmin(np.linalg.norm(flat - flat.mean(axis=0), axis=1))
    noise = np.outer(np.random.default_rng(0).normal(0, 0.01, len(flat)), [0, 0, 1])
    heights = np.linspace(0, 1.5 * PARAMETERS.face_height, 151)
    moved = []
    for height in heights:
        surface = flat.copy()
        surface[middle, 2] = height
        moved.append(height - flattened(flat + noise, faces, surface, 0.01)[middle, 2])
    moved = np.array(moved)
    inside = heights < (1 - 1 / FADING) * PARAMETERS.face_height
    assert moved[inside] == pytest.approx(heights[inside], abs=0.01)
    assert np.abs(moved[heights > 1.1 * PARAMETERS.face_height]).max() < 0.01
    assert np.abs(np.diff(moved)).max() < 2 * FADING * heights[1]


def test_the_fewer_flat_faces_there_are_the_less_they_count():
    noisy, start = noisy_cube(0.2), noisy_cube(0.04, seed=1)
    faces = flat_faces(noisy, FACES, start)
    whole = faces.flattened(noisy, start) - start
    share = np.mean(faces.face >= 0)
    inside = faces.of_vertices() >= 0
    for part in (0.25, 0.5, 0.75):
        with using(replace(PARAMETERS, least_flat=share / (1 + part))):
            moved = faces.flattened(noisy, start) - start
        assert moved[inside] == pytest.approx(part * whole[inside], abs=1e-3 * EDGE)


def test_flat_faces_are_a_large_part_of_the_mixture_on_a_cube():
    found = denoise(noisy_cube(0.2), FACES)
    names = [each.name for each in found.plan.filters]
    mixture = found.plan.mixtures[STRENGTHS.index(1.0)]
    assert mixture.coefficients(names.index("flat faces")).mean() > 0.3
    error = np.sqrt(np.mean(off_the_cube(found.positions) ** 2)) / EDGE
    assert error < 0.2 * 0.2


def test_low_spikes_leave_no_dents():
    """Every fifth vertex is a spike, many no higher than the clean surface's own roughness."""
    is_spike = np.random.default_rng(2).random(len(CUBE)) < 0.2
    spiky = np.where(is_spike[:, None], noisy_cube(0.6, seed=3), CUBE)
    found = denoise(spiky, FACES)
    assert "impulsive" in " ".join(found.notes)
    assert found.other_readings == ()
    on_one_face = np.isclose(np.abs(CUBE), 1).sum(axis=1) == 1
    dents = off_the_cube(found.positions)[on_one_face] / EDGE
    # As smooth as clean meshes are.
    assert np.sqrt(np.mean(dents**2)) < PARAMETERS.clean_roughness
    again = denoise(spiky, FACES, plan=found.plan)
    assert np.array_equal(again.positions, found.positions)


def test_faces_merge_again_where_their_vertices_say_less_than_was_assumed(monkeypatch):
    """A ridge of eight degrees: noise of scanners may look so, white noise does not."""
    flat, faces = meshes.flat_grid(40, 40)
    way = np.abs(flat[:, 0] - flat[:, 0].mean())
    ridge = flat - np.outer(way * np.tan(np.radians(4)), [0, 0, 1])
    noisy = ridge + np.outer(np.random.default_rng(0).normal(0, 0.2, len(flat)), [0, 0, 1])

    def n_faces():
        found = flat_faces(noisy, faces, ridge)
        return len(np.unique(found.face[found.face >= 0]))

    assert n_faces() == 2
    monkeypatch.setattr(PlaneFits, "own_part", lambda fits: 1e-4)
    assert n_faces() == 1
