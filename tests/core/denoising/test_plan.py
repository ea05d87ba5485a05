"""Plan of a run: its radius, its parts, and what it does on another frame."""

from dataclasses import replace

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import InputError, PreparedMesh, denoise
from adaptive_fairing.core.denoising.plan import STRENGTHS, DenoisePlan

FACES = meshes.torus(48, 24)[1]


def frame(seed):
    vertices, _ = meshes.torus(48, 24)
    return vertices + np.random.default_rng(seed).normal(0, 0.03, vertices.shape)


@pytest.fixture(scope="module")
def prepared():
    return PreparedMesh(frame(0), FACES)


@pytest.fixture(scope="module")
def first(prepared):
    return denoise(frame(0), FACES, prepared=prepared)


def distance_to_torus(points):
    ring = np.hypot(points[:, 0], points[:, 1]) - 2
    return np.sqrt(np.mean((np.hypot(ring, points[:, 2]) - 1) ** 2))


def test_another_frame_is_filtered_alike(first, prepared):
    again = denoise(frame(0), FACES, prepared=prepared, plan=first.plan)
    assert np.array_equal(again.shapes, first.shapes)
    other = denoise(frame(1), FACES, prepared=prepared, plan=first.plan)
    assert other.radius == first.radius
    assert distance_to_torus(other.positions) < 0.45 * distance_to_torus(frame(1))


def test_one_of_another_mesh_is_refused(first):
    with pytest.raises(InputError, match="plan is of a mesh of 1152 vertices, not 642"):
        denoise(*meshes.icosphere(3), plan=first.plan)


def test_of_a_part_it_has_what_the_whole_has_there(first):
    plan, vertices = first.plan, np.array([700, 3, 41])
    part = plan.at(vertices)
    for name in ("noise", "impulsive", "reach"):
        assert np.array_equal(getattr(part, name), getattr(plan, name)[vertices])
    pairs = [*zip(part.pilots, plan.pilots, strict=True)]
    for own, whole in (*pairs, *zip(part.mixtures, plan.mixtures, strict=True)):
        assert np.array_equal(own.used, whole.used)
        for index in whole.used:
            assert np.array_equal(own.coefficients(index), whole.coefficients(index)[vertices])
    assert (part.filters, part.radius) == (plan.filters, plan.radius)


@pytest.mark.parametrize("deviation", [1.5, 3.0])
def test_the_radius_is_the_standard_deviation_of_the_filter_that_keeps_as_much(deviation):
    """A Gaussian filter on equilateral triangles keeps the weight that a vertex has in it."""
    vertices, _ = meshes.flat_grid(60, 60)
    distance = np.linalg.norm(vertices - vertices[30 * 61 + 30], axis=1)
    weights = np.exp(-((distance / deviation) ** 2) / 2)
    nothing = np.zeros(1)
    plan = DenoisePlan.idle(nothing, nothing, nothing)
    assert (plan.radius, plan.is_idle) == (0, True)
    kept = np.where(np.array(STRENGTHS) == 1, 1 / weights.sum(), 0.5)
    assert replace(plan, kept=kept).radius == pytest.approx(deviation, rel=0.05)
