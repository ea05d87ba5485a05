"""Free boundaries: removal of their noise, preservation of their place."""

from itertools import product

import numpy as np
import pytest

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.boundary_curves import BoundaryCurves, middle, widest
from adaptive_fairing.core.denoising.noise_model import NoiseCorrelation
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

FREE = DenoiseSettings(boundary="free")
SIDE = 40
NOISE = 0.2


def sheet(n=SIDE, hole=0):
    """A flat square sheet of unit edges, its triangles turned at random; a square hole in it."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    index = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = (
        part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    )
    first, second = np.stack([a, b, c, a, c, d], 1), np.stack([a, b, d, b, c, d], 1)
    turned = np.random.default_rng(1).random(len(a)) < 0.5
    cells = np.where(turned[:, None], first, second)
    if hole:
        row, column = np.divmod(np.arange(len(a)), n)
        middle_of = np.maximum(abs(row - n // 2 + 0.5), abs(column - n // 2 + 0.5))
        cells = cells[middle_of > hole / 2]
    return np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), cells.reshape(-1, 3)


def area(vertices, faces):
    corner = vertices[faces]
    crosses = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return np.linalg.norm(crosses, axis=1).sum() / 2


def boundary_errors(points, clean, edge):
    """Distance of the boundary's vertices to their sides of the sheet, in space."""
    at_side = (clean[edge, :2] == 0) | (clean[edge, :2] == SIDE)
    off = np.where(at_side, (points - clean)[edge, :2], 0)
    return np.linalg.norm(np.column_stack([off, points[edge, 2]]), axis=1)


def boundary(faces, n):
    return TriangleTopology(faces, n).boundary_vertices


@pytest.fixture(scope="module")
def noisy_sheets():
    clean, faces = sheet()
    noise = NOISE * np.random.default_rng(0).normal(size=clean.shape)
    across = clean + noise * [0, 0, 1]
    return {
        name: (noisy, denoise(noisy, faces, FREE).positions)
        for name, noisy in (("across", across), ("all", clean + noise))
    }


@pytest.mark.parametrize(("directions", "most"), [("across", 0.6), ("all", 0.7)])
def test_a_boundary_loses_noise_and_the_area_is_kept(noisy_sheets, directions, most):
    clean, faces = sheet()
    noisy, result = noisy_sheets[directions]
    edge = boundary(faces, len(clean))
    before, after = (boundary_errors(each, clean, edge) for each in (noisy, result))
    assert np.sqrt(np.mean(after**2)) < most * np.sqrt(np.mean(before**2))
    # Drawn inwards by half an edge it would be 5 % less.
    assert area(result, faces) == pytest.approx(area(clean, faces), rel=0.01)


def test_corners_are_not_rounded_more_than_the_noise(noisy_sheets):
    clean, _ = sheet()
    corners = [0, SIDE, -1 - SIDE, -1]
    inwards = np.sign(SIDE / 2 - clean[corners, :2]) / 2**0.5
    for noisy, result in noisy_sheets.values():
        into = np.einsum("cd,cd->c", (result - noisy)[corners, :2], inwards)
        assert np.abs(into).max() < 2 * NOISE


def test_a_boundary_without_noise_sideways_does_not_move_sideways(noisy_sheets):
    clean, faces = sheet()
    noisy, result = noisy_sheets["across"]
    edge = boundary(faces, len(clean))
    moved = boundary_errors((result - noisy) * [1, 1, 0] + clean, clean, edge)
    assert np.sqrt(np.mean(moved**2)) < 0.1 * NOISE


def test_a_clean_open_mesh_comes_back_bit_by_bit():
    vertices, faces = sheet(hole=10)
    vertices[:, 2] = 3 * np.sin(vertices[:, 0] / 9) * np.cos(vertices[:, 1] / 7)
    assert np.array_equal(denoise(vertices, faces, FREE).positions, vertices)


def test_a_closed_mesh_has_no_boundary_and_a_small_hole_does_not_move_sideways():
    vertices, faces = sheet(hole=2)
    noise = NOISE * np.random.default_rng(0).normal(size=vertices.shape)
    start = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices + noise)
    curves = BoundaryCurves(start, np.where(start.topology.on_boundary, 0, NOISE))
    normals = np.tile([0.0, 0, 1], (len(vertices), 1))
    moves = curves.moves(0.01 * normals, normals, 1.0)
    is_hole = np.abs(vertices[curves.vertices, :2] - SIDE / 2).max(axis=1) < 2
    assert np.count_nonzero(is_hole) == 8
    assert np.abs(moves[is_hole, :2]).max() == 0
    assert np.abs(moves[~is_hole, :2]).max() > 0.1


def test_where_the_filters_remove_nothing_a_boundary_stays():
    vertices, faces = sheet()
    noise = NOISE * np.random.default_rng(0).normal(size=vertices.shape)
    start = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices + noise)
    curves = BoundaryCurves(start, np.where(start.topology.on_boundary, 0, NOISE))
    normals = np.tile([0.0, 0, 1], (len(vertices), 1))
    assert np.abs(curves.moves(0 * normals, normals, 1.0)).max() == 0


def smooth_heights(vertices, faces, passes, seed):
    """Noise of a sheet that was averaged with the neighbours' so many times."""
    surface = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    heights = np.random.default_rng(seed).normal(size=len(vertices))
    heights = NoiseCorrelation(passes=passes).applied(heights, surface)
    return NOISE / heights.std() * heights[:, None] * [0, 0, 1]


def test_a_boundary_loses_smooth_noise():
    clean, faces = sheet()
    edge, left = boundary(faces, len(clean)), []
    for passes, seed in product((4, 8), range(3)):
        noise = smooth_heights(clean, faces, passes, seed)
        result = denoise(clean + noise, faces, FREE).positions
        left.append(result[edge, 2].std() / noise[edge, 2].std())
    # With averages along the boundary alone it was 0.8.
    assert np.mean(left) < 0.73


def test_averages_keep_the_part_of_white_noise_that_is_said():
    kernel = np.zeros(101)
    kernel[50] = 1
    for passes in range(1, 9):
        kernel = (2 * kernel + np.roll(kernel, 1) + np.roll(kernel, -1)) / 4
        assert kernel[50] == pytest.approx(middle(passes), rel=1e-12)
        assert np.sum(kernel**2) == pytest.approx(middle(2 * passes), rel=1e-12)


def test_the_widest_average_is_taken_that_leaves_no_narrower_ones_interval():
    noise = np.array([1.0, 1.0, 0.0])
    ways = [(np.array([0.5, 0.5, 0.5]), 0.5), (np.array([0.6, 3.0, 0.6]), 0.25)]
    assert widest(ways, noise).tolist() == [0.6, 0.5, 0.0]
