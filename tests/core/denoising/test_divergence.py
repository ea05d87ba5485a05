"""Divergence of filters, measured with a probe, against the exact trace."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising import filters
from adaptive_fairing.core.denoising.filters import FilterBank, mesh_family
from adaptive_fairing.core.denoising.mixture import filter_divergence
from adaptive_fairing.core.denoising.noise.own_numbers import OwnNumbers
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

SIZE = 0.02
"""Of the probes, in local edge lengths."""


def exact_filters(size, seed=0):
    """Linear filters that remove F_k x, with F_k symmetric and sparse like a diffusion's."""
    offsets = np.arange(size)
    distance = np.abs(offsets[:, None] - offsets[None])
    distance = np.minimum(distance, size - distance)
    kernels = [np.exp(-((distance / width) ** 2) / 2) for width in (0.6, 1.2, 2.5)]
    return [np.eye(size) - kernel / kernel.sum(axis=1) for kernel in kernels]


def test_a_probe_of_random_signs_finds_the_trace_of_a_linear_filter():
    """Its error is the sum of the entries off the diagonal: 2 ‖offdiag‖_F² in variance."""
    size = 600
    generator = np.random.default_rng(0)
    positions = generator.normal(size=size)
    probe = SIZE * generator.choice([-1.0, 1.0], size)
    filters = exact_filters(size)
    removed = np.stack([each @ positions for each in filters])
    shadow = np.stack([each @ (positions + probe) for each in filters])
    found = filter_divergence(removed, shadow, probe, SIZE).sum(axis=1)
    for total, each in zip(found, filters, strict=True):
        deviation = np.sqrt(2 * np.sum((each - np.diag(np.diag(each))) ** 2))
        assert abs(total - np.trace(each)) < 3 * deviation


def test_the_mean_over_all_probes_is_the_diagonal():
    """Without chance: over all signs of three vertices the others cancel exactly."""
    matrix = np.array([[0.5, 0.2, -0.1], [0.3, 0.25, 0.05], [0.0, 0.4, 0.75]])
    positions = np.array([1.0, -2.0, 0.5])
    total = np.zeros(3)
    for bits in range(8):
        probe = SIZE * np.where((bits >> np.arange(3)) & 1, 1.0, -1.0)
        removed, shadow = (matrix @ each for each in (positions, positions + probe))
        total += filter_divergence(removed[None], shadow[None], probe, SIZE)[0]
    np.testing.assert_allclose(total / 8, np.diag(matrix), rtol=1e-12)


def test_probes_of_different_sizes_count_alike():
    """A filter that removes everything removes all of the noise at each vertex."""
    waves = np.cos(np.random.default_rng(0).uniform(0, 2 * np.pi, 400))
    probe = SIZE * waves / np.sqrt(np.mean(waves**2))
    found = filter_divergence(np.zeros((1, 400)), probe[None].copy(), probe, SIZE)
    np.testing.assert_allclose(found, 1, rtol=1e-12)


@pytest.mark.parametrize("shape", ["sphere", "torus"])
@pytest.mark.parametrize("n_probes", [1, 4])
def test_the_probes_of_a_mesh_find_the_trace_of_its_diffusions(shape, n_probes, monkeypatch):
    """With the probes that belong to the mesh, for the diffusions in the metric of the mesh.

    Their mean is twice as exact with four times as many.  Solves that end early are not linear: a
    probe as large as the noise ends them elsewhere than the step of one vertex does.
    """
    monkeypatch.setattr(filters, "TOLERANCE", 1e-6)
    vertices, faces = meshes.noisy_ball(2, 0.02) if shape == "sphere" else meshes.torus(18, 9)
    vertices = vertices + 0.02 * np.random.default_rng(1).normal(size=vertices.shape)
    n = len(vertices)
    topology = TriangleTopology(faces, n)
    frame = TriangleSurface(topology, vertices)
    bank = FilterBank(frame, lambda report: None)

    def removed_from(positions):
        _, filtered = bank.started(TriangleSurface(topology, positions))
        return np.stack([frame.along_normal(positions - each) for each in filtered.values()])

    probes = [SIZE * each for each in OwnNumbers(vertices, frame).probes(n_probes)]
    removed = removed_from(vertices)
    shadows = [removed_from(vertices + frame.raised(each)) for each in probes]
    pairs = zip(shadows, probes, strict=True)
    found = np.mean([filter_divergence(removed, *pair, SIZE) for pair in pairs], axis=0)
    # The exact diagonal, vertex by vertex: the response to a step of one vertex alone.
    jacobian = np.empty((len(mesh_family().filters), n, n))
    for vertex in range(n):
        step = np.zeros(n)
        step[vertex] = SIZE
        moved = removed_from(vertices + frame.raised(step)) - removed
        jacobian[:, :, vertex] = moved / SIZE
    for row, matrix in zip(found, jacobian, strict=True):
        off = matrix - np.diag(np.diag(matrix))
        deviation = np.sqrt((np.sum(off**2) + np.sum(off * off.T)) / n_probes)
        assert abs(row.sum() - np.trace(matrix)) < 3 * deviation
        assert row.mean() == pytest.approx(np.trace(matrix) / n, rel=0.1)
