"""Diffusions from one small space, against the same diffusions carried out step by step."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.filters import all_diffusions
from adaptive_fairing.core.denoising.lifted_metric import LiftedMetric, linear_elements
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface
from adaptive_fairing.core.linalg.edge_matrix import EdgePattern
from adaptive_fairing.core.linalg.krylov_filters import Diffusion, removed_by

STEEP = all_diffusions()
METRICS = [LiftedMetric(), LiftedMetric(1), LiftedMetric(1, 0.3), LiftedMetric(0, 0.05)]
MILD = Diffusion(0.5, 1, 1)


def noisy_mesh(loose=0):
    vertices, faces = meshes.random_closed(3)
    noise = 0.05 * np.random.default_rng(0).normal(size=vertices.shape)
    return np.concatenate([vertices + noise, np.full((loose, 3), 7.0)]), faces


def matrices_of(metric, vertices, faces):
    surface = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    return linear_elements(EdgePattern(surface.topology), metric.lengths(surface))


def removed(diffusions, matrices, control, is_loose=None, **options):
    reports = []
    is_loose = np.zeros(len(control), dtype=bool) if is_loose is None else is_loose
    bending = matrices[1].product(control.T).T
    result = removed_by(diffusions, *matrices, bending, is_loose, reports.append, **options)
    assert all(report.converged for report in reports)
    return result


def step_by_step(diffusion, mass, stiffness, control):
    """Repeat p solves in each of k steps, as the definition says."""
    mass, stiffness = mass.full().toarray(), stiffness.full().toarray()
    once = np.linalg.solve(mass + diffusion.time * stiffness, mass)
    result = control
    for _ in range(diffusion.steps):
        whole, result = result, np.zeros_like(result)
        for _ in range(diffusion.order):
            result = result + once @ (whole - result)
    return control - result


@pytest.mark.parametrize(("tolerance", "bound"), [(1e-2, 0.2), (1e-4, 2e-3), (1e-7, 2e-6)])
@pytest.mark.parametrize("metric", METRICS, ids=str)
def test_every_diffusion_of_a_family_is_what_its_steps_give(metric, tolerance, bound):
    vertices, faces = noisy_mesh()
    matrices = matrices_of(metric, vertices, faces)
    results = removed(STEEP, matrices, vertices, tolerance=tolerance)
    for diffusion, found in zip(STEEP, results, strict=True):
        reference = step_by_step(diffusion, *matrices, vertices)
        error = np.linalg.norm(found - reference) / np.linalg.norm(reference)
        assert error < bound, diffusion


def test_shares_removed_are_those_of_the_repeated_steps():
    eigenvalue, diffusion = 0.7, Diffusion(1.2, 4, 3)
    keeps = 1 / (1 + diffusion.time * eigenvalue)
    kept = 1.0
    for _ in range(diffusion.steps):
        whole, kept = kept, 0.0
        for _ in range(diffusion.order):
            kept += keeps * (whole - kept)
    assert diffusion.removed(np.array([eigenvalue])) == pytest.approx([1 - kept], rel=1e-13)


def test_little_that_is_removed_keeps_its_digits():
    share = Diffusion(1.0, 2, 4).removed(np.array([1e-7]))
    assert share == pytest.approx([4e-14], rel=1e-6)


def test_the_choice_of_the_axes_does_not_matter():
    vertices, faces = noisy_mesh()
    matrices = matrices_of(LiftedMetric(), vertices, faces)
    turn, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    (plain,), (turned,) = (removed([MILD], matrices, v) for v in (vertices, vertices @ turn))
    assert np.abs(turned - plain @ turn).max() < 1e-10


def test_a_point_has_nothing_to_remove():
    vertices, faces = noisy_mesh()
    matrices = matrices_of(LiftedMetric(), vertices, faces)
    for found in removed(STEEP, matrices, np.zeros_like(vertices)):
        assert not found.any()


def test_loose_vertices_stay_and_do_not_matter():
    vertices, faces = noisy_mesh(loose=3)
    is_loose = np.arange(len(vertices)) >= len(vertices) - 3
    (found,) = removed([MILD], matrices_of(LiftedMetric(), vertices, faces), vertices, is_loose)
    assert not found[is_loose].any()
    alone = vertices[~is_loose]
    (reference,) = removed([MILD], matrices_of(LiftedMetric(), alone, faces), alone)
    assert np.abs(found[~is_loose] - reference).max() < 1e-12
