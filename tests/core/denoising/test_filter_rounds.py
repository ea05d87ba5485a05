"""Rounds of named filters, of which later ones follow what those before them made."""

from collections import defaultdict

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, PreparedMesh, denoise
from adaptive_fairing.core.denoising.filters import (
    OTHER_FACTORS,
    FilterBank,
    FilterFamily,
    NormalFamily,
    mesh_family,
    rounds_for,
)
from adaptive_fairing.core.denoising.flat_faces import FlatFaces
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.plan import STRENGTHS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

POINTS, FACES = meshes.noisy_ball(3, 0.03)


def all_families():
    """Filters of the mesh and of all rounds, in the order in which they are used."""
    return mesh_family(), *(family for families in rounds_for(0.2) for family in families)


@pytest.fixture(scope="module")
def prepared():
    return PreparedMesh(POINTS, FACES)


def noisy_cube(amplitude):
    """A subdivided cube with noise along the directions from its middle: creases, and no margin."""
    corners, faces = meshes.cube(4)
    outward = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    height = np.random.default_rng(1).normal(0, amplitude * 2 / 2**4, (len(corners), 1))
    return corners + height * outward, faces


def test_every_filter_has_a_name_of_its_own():
    filters = [each for family in all_families() for each in family.filters]
    assert len({each.name for each in filters}) == len(filters)


@pytest.mark.parametrize("features, kind", [("sharp", "keeps"), ("smooth", "ignores")])
def test_features_decide_which_filters_are_mixed(features, kind):
    plan = denoise(*noisy_cube(0.15), DenoiseSettings(features=features)).plan
    expected = tuple(each for family in all_families() for each in family.filters)
    assert plan.filters == expected
    used = {plan.filters[index].creases for index in plan.mixtures[2].used}
    assert used == {kind}


def test_a_metric_that_does_not_bend_rounds_creases_and_the_narrowest_keeps_them():
    """What the families say of themselves agrees with the angles of their metrics."""
    families = [family for family in all_families() if isinstance(family, FilterFamily)]
    angles = {
        kind: [family.metric.angle for family in families if family.creases == kind]
        for kind in ("ignores", "sees", "keeps")
    }
    assert set(angles["ignores"]) == {None}
    assert max(angles["keeps"]) < min(angles["sees"])


def test_less_noise_makes_the_angles_smaller_in_proportion():
    half, full = (rounds_for(part * PARAMETERS.coarse_noise) for part in (0.5, 1.0))
    # More noise leaves out the normals of the noisy mesh, nothing else.
    more = rounds_for(2 * PARAMETERS.coarse_noise)
    assert more == (*full[:2], full[2][:1], *full[3:])
    for some, others in zip(half, full, strict=True):
        for one, other in zip(some, others, strict=True):
            assert one.filters == other.filters
            if isinstance(one, FilterFamily) and other.metric.angle is not None:
                assert one.metric.angle == pytest.approx(other.metric.angle / 2)


def test_a_later_round_takes_its_metric_from_the_mixture_of_the_rounds_before(
    prepared, monkeypatch
):
    """Each surface that a round's metrics are taken from, rebuilt from the filters before it."""
    calls = []
    filtered = FilterBank.filtered

    def recorded(self, noisy, surface, families):
        found = list(filtered(self, noisy, surface, families))
        calls.append((noisy.positions, surface.positions, [result for _, result in found]))
        return iter(found)

    monkeypatch.setattr(FilterBank, "filtered", recorded)
    plan = denoise(POINTS, FACES, prepared=prepared).plan
    both_runs = list(calls)
    calls.clear()
    denoise(POINTS, FACES, prepared=prepared, plan=plan)
    assert len(calls) == len(plan.pilots) + 1
    positions = calls[0][0]
    # The others are of the probes, at the same time.
    surfaces = [surface for each, surface, _ in both_runs if np.array_equal(each, positions)]
    for surface, (_, again, _) in zip(surfaces, calls, strict=True):
        assert np.array_equal(surface, again)
    noisy = TriangleSurface(prepared.surface.topology, positions)
    start, of_mesh = FilterBank(noisy, lambda report: None).started(noisy)
    np.testing.assert_allclose(calls[0][1], start.positions, rtol=0, atol=1e-12)
    so_far = [*of_mesh.values(), *calls[0][2]]
    for pilot, (_, surface, results) in zip(plan.pilots, calls[1:], strict=True):
        mixture = positions - sum(
            pilot.coefficients(index)[:, None] * (positions - each)
            for index, each in enumerate(so_far)
        )
        moved = np.linalg.norm(mixture - positions)
        assert moved > 0
        assert np.linalg.norm(surface - mixture) < 1e-6 * moved  # kept in single precision
        so_far += results
    assert len(plan.mixtures) == len(STRENGTHS)
    assert all(each.by_class.shape[-1] == len(so_far) for each in plan.mixtures)


@pytest.mark.parametrize("points, faces", [(POINTS, FACES), noisy_cube(0.15)], ids=["ball", "cube"])
def test_a_plan_repeats_all_rounds_bit_by_bit(points, faces):
    prepared = PreparedMesh(points, faces)
    found = denoise(points, faces, prepared=prepared)
    assert len(found.plan.pilots) == len(rounds_for(0.2)) - 1
    again = denoise(points, faces, prepared=prepared, plan=found.plan)
    assert np.array_equal(again.positions, found.positions)


def test_probes_are_flattened_on_the_faces_of_the_surface_itself(monkeypatch):
    used = defaultdict(set)
    flattened = FlatFaces.flattened

    def recorded(self, noisy, surface):
        used[id(noisy)].add(self)
        return flattened(self, noisy, surface)

    monkeypatch.setattr(FlatFaces, "flattened", recorded)
    denoise(*noisy_cube(0.15))
    first, *others = used.values()
    assert len(first) == 1 + len(OTHER_FACTORS)
    assert others and all(each == first for each in others)


@pytest.mark.parametrize("noise, is_used", [(0.1, True), (0.4, False)])
def test_normals_of_the_noisy_mesh_are_used_if_the_noise_leaves_something_in_them(noise, is_used):
    found = [family for families in rounds_for(noise) for family in families]
    of_noisy = [isinstance(family, NormalFamily) and family.is_of_noisy for family in found]
    assert sum(of_noisy) == is_used
