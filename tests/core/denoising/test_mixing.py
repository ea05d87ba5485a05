"""Mixture of the filters as a whole."""

from dataclasses import replace

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import denoise
from adaptive_fairing.core.denoising.filters import FilterBank
from adaptive_fairing.core.denoising.mesh_parts import MeshParts
from adaptive_fairing.core.denoising.parameters import PARAMETERS, using


def sheet_with_a_speck(noise=0.5, seed=0):
    """A flat sheet, its edges drawn together in the middle, with noise of one amplitude."""
    flat, faces = meshes.flat_grid(40, 40)
    away = flat - flat.mean(axis=0)
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    uneven = flat - 0.95 * away * np.exp(-((distance / 6) ** 4))
    heights = np.random.default_rng(seed).normal(0, noise, len(flat))
    return uneven + np.outer(heights, [0, 0, 1]), faces


def test_no_vertex_has_more_weight_than_noise_of_one_edge_gives(monkeypatch):
    """Where the noise is larger than the edges, it is the unit of the risk."""
    seen = []
    mixtures = MeshParts.best_mixtures

    def observed(parts, removed, divergence, variances):
        seen.append((removed, variances))
        return mixtures(parts, removed, divergence, variances)

    monkeypatch.setattr(MeshParts, "best_mixtures", observed)
    found = denoise(*sheet_with_a_speck())
    is_loud = found.plan.noise > 1
    assert np.count_nonzero(is_loud) > 20
    removed, (variance,) = seen[0]
    assert variance[is_loud] == pytest.approx(PARAMETERS.noise_factor**2)
    assert variance.max() == pytest.approx(PARAMETERS.noise_factor**2)
    # What filters remove of the noise, too, has a mean square of about 1 in that unit.
    sizes = [np.sqrt(np.mean(row[is_loud] ** 2, dtype=float)) for row in removed]
    assert 0.5 < max(sizes) < 2


@pytest.mark.parametrize("times, expected", [(0.5, 1), (1, 1), (1.5, 2), (3, 3), (100, 4)])
def test_probes_have_enough_vertices_together(monkeypatch, times, expected):
    """As many runs are made as that takes, besides the one on the mesh itself, four at most."""
    vertices, faces = meshes.flat_grid(30, 30)
    vertices[:, 2] = np.random.default_rng(0).normal(0, 0.2, len(vertices))
    n_inner = 29 * 29
    banks = []
    started = FilterBank.started

    def observed(bank, noisy):
        banks.append(bank)
        return started(bank, noisy)

    monkeypatch.setattr(FilterBank, "started", observed)
    with using(replace(PARAMETERS, least_probed=round(times * n_inner))):
        assert denoise(vertices, faces).noise_level > 0
    assert banks.count(banks[-1]) == 1 + expected
