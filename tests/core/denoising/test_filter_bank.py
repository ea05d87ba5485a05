"""Filter bank against its formulas, carried out on dense matrices."""

import numpy as np
import pytest
from scipy.linalg import eigh
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising import filters
from adaptive_fairing.core.denoising.filters import (
    IGNORES,
    FilterBank,
    FilterFamily,
    FlatFamily,
    NormalFamily,
    gentle_diffusions,
    mesh_family,
)
from adaptive_fairing.core.denoising.lifted_metric import (
    LiftedMetric,
    boundary_flux,
    linear_elements,
)
from adaptive_fairing.core.denoising.normal_filter import Smoothing
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface
from adaptive_fairing.core.linalg.edge_matrix import EdgePattern

FIRST = mesh_family().diffusions[len(gentle_diffusions())]
SHAPES = {"uneven": meshes.graded_sphere(2), "open": meshes.bumpy_disc(0)}


@pytest.fixture
def exact(monkeypatch):
    """Solves that follow the formulas to the last digits."""
    monkeypatch.setattr(filters, "TOLERANCE", 1e-10)


def surface_of(vertices, faces):
    return TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)


def bank_of(surface):
    return FilterBank(surface, lambda report: None)


def diffused(diffusions, noisy, surface, metric, flux_fraction=0.0):
    """Positions after each diffusion, by the eigenvectors of M⁻¹L."""
    squares = metric.lengths(surface)
    mass, stiffness = linear_elements(EdgePattern(surface.topology), squares)
    # Vertices whose edges are short beside those around them count for more.
    root = np.sqrt(noisy.smooth_spacing / noisy.spacing)
    stiffness = stiffness.full().toarray()
    values, vectors = eigh(stiffness, mass.full().toarray() * np.outer(root, root))
    values = np.maximum(values, 1e-9)
    bending = stiffness @ noisy.positions - flux_fraction * boundary_flux(surface, squares)
    parts = vectors.T @ bending
    return [
        noisy.positions - vectors @ ((each.removed(values) / values)[:, None] * parts)
        for each in diffusions
    ]


@pytest.mark.usefixtures("exact")
@pytest.mark.parametrize("shape", SHAPES)
def test_the_first_filters_are_diffusions_in_the_metric_of_the_mesh(shape):
    noisy = surface_of(*SHAPES[shape])
    surface, filtered = bank_of(noisy).started(noisy)
    assert tuple(filtered) == mesh_family().filters
    expected = diffused((FIRST, *mesh_family().diffusions), noisy, noisy, LiftedMetric())
    found = [surface.positions, *filtered.values()]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7)


@pytest.mark.usefixtures("exact")
@pytest.mark.parametrize("shape", SHAPES)
def test_later_filters_take_their_metric_from_the_surface_and_leave_out_its_boundary_flux(shape):
    noisy = surface_of(*SHAPES[shape])
    surface = TriangleSurface(noisy.topology, noisy.positions * [1, 1, 0.5])
    family = FilterFamily("wide", IGNORES, LiftedMetric(1, 0.3), mesh_family().diffusions)
    found = dict(bank_of(noisy).filtered(noisy, surface, (family,)))
    assert tuple(found) == family.filters
    fraction = PARAMETERS.boundary_flux_fraction
    expected = diffused(family.diffusions, noisy, surface, family.metric, fraction)
    np.testing.assert_allclose(list(found.values()), expected, rtol=0, atol=1e-7)


@pytest.mark.usefixtures("exact")
def test_one_solve_for_all_fits_gives_what_each_gives_alone():
    noisy = surface_of(*meshes.noisy_ball(2, 0.05))
    smoothings = Smoothing(0.5, (1, 3)), Smoothing(1.0, (2,))
    together = bank_of(noisy).filtered(noisy, noisy, (NormalFamily("all", smoothings),))
    families = [
        NormalFamily("one", (Smoothing(each.angle, (passes,)),))
        for each in smoothings
        for passes in each.passes
    ]
    alone = bank_of(noisy).filtered(noisy, noisy, families)
    found, expected = ([positions for _, positions in each] for each in (together, alone))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)
    assert np.abs(found[0] - found[1]).max() > 1e-3


def test_loose_vertices_stay():
    vertices, faces = meshes.noisy_ball(2, 0.05)
    noisy = surface_of(np.vstack([vertices, [(9.0, 9, 9)]]), faces)
    bank = bank_of(noisy)
    surface, filtered = bank.started(noisy)
    fits = dict(bank.filtered(noisy, surface, (NormalFamily("n", (Smoothing(1.0, (2,)),)),)))
    for positions in (surface.positions, *filtered.values(), *fits.values()):
        assert np.array_equal(positions[-1], [9, 9, 9])
        assert np.isfinite(positions).all()


def test_flat_faces_are_made_flat_and_round_surfaces_are_given_back():
    corners, faces = meshes.cube(4)
    noise = np.random.default_rng(0).normal(0, 0.005, corners.shape)
    noisy, clean = surface_of(corners + noise, faces), surface_of(corners, faces)
    ((_, flat),) = bank_of(noisy).filtered(noisy, clean, (FlatFamily("flat"),))
    on_one_side = np.isclose(np.abs(corners), 1).sum(axis=1) == 1

    def height(points):
        largest = np.abs(corners).argmax(axis=1)
        heights = np.abs(np.take_along_axis(points, largest[:, None], axis=1)[:, 0]) - 1
        return np.sqrt(np.mean(heights[on_one_side] ** 2))

    assert height(flat) < 0.25 * height(noisy.positions)
    ball = surface_of(*meshes.noisy_ball(3, 0.01))
    smooth = surface_of(*meshes.icosphere(3))
    ((_, positions),) = bank_of(ball).filtered(ball, smooth, (FlatFamily("flat"),))
    assert np.array_equal(positions, smooth.positions)
