"""Rare classes are integrated together: the same integrals as class by class."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import LoopSpace, TriangleTopology
from adaptive_fairing.core.fem import table_cache
from adaptive_fairing.core.fem.patch_tables import MASS, STIFFNESS, SUM, PatchTables
from adaptive_fairing.core.loop.basis import basis_table
from adaptive_fairing.core.loop.patch_class import Corner
from adaptive_fairing.core.loop.quadrature import quadrature_choice

# All with 24 points, and 10, 13 and 15 control points.
CLASSES = [(3, 6, 7), (3, 8, 8), (3, 9, 9)]


def test_one_table_for_each_triangle_integrates_as_those_of_its_classes():
    choice = quadrature_choice(1e-3)
    tables = [basis_table(tuple(Corner(valence) for valence in each), choice) for each in CLASSES]
    n_points, n_control_points = 24, 15
    assert {table.weights.shape[1] for table in tables} == {n_points}
    together = PatchTables(tables)
    assert together.n_control_points == n_control_points
    random = np.random.default_rng(1)
    control = random.normal(size=(3, n_control_points, 3))
    fluxes = random.normal(size=(3, 2, n_points, 3))
    coefficients = random.normal(size=(4, n_points, 3))

    jets = np.empty((3, 6 * n_points, 3))
    sums = np.empty((3, n_control_points, 3))
    local = np.empty((len(together.pairs[0]), 3))
    together.evaluate(control, 6, out=jets)
    together.flux_sums(fluxes, out=sums)
    together.local_matrices(coefficients, SUM, out=local)

    for k, table in enumerate(tables):
        alone = PatchTables([table], 1000)
        used = alone.n_control_points
        own = slice(k, k + 1)
        expected_jets = np.empty((3, 6 * n_points, 1))
        expected_sums = np.empty((3, used, 1))
        expected_local = np.empty((len(alone.pairs[0]), 1))
        alone.evaluate(control[:, :used, own], 6, out=expected_jets)
        alone.flux_sums(fluxes[..., own], out=expected_sums)
        alone.local_matrices(coefficients[..., own], SUM, out=expected_local)

        np.testing.assert_allclose(jets[..., own], expected_jets, atol=1e-12)
        np.testing.assert_allclose(sums[:, :used, own], expected_sums, atol=1e-12)
        assert not sums[:, used:, own].any()
        is_used = together.pairs[1] < used
        np.testing.assert_allclose(local[is_used, own], expected_local, atol=1e-12)
        assert not local[~is_used, own].any()


@pytest.mark.parametrize("terms", [MASS, STIFFNESS, SUM], ids=["M", "L", "sum"])
def test_around_a_pole_equal_functions_are_integrated_once(terms):
    """Against products of all pairs at all points, one by one."""
    table = basis_table((Corner(200), Corner(6), Corner(6)), quadrature_choice(1e-3))
    n_points, n_triangles = table.weights.shape[1], 20
    tables = PatchTables([table], n_triangles)
    coefficients = np.random.default_rng(1).normal(size=(4, n_points, n_triangles))
    local = np.empty((len(tables.pairs[0]), n_triangles))
    tables.local_matrices(coefficients, terms, out=local)

    phi, d1, d2 = table.values[:3]
    c0, c1, c2, c3 = coefficients * table.weights[[0, 1, 1, 1], :, None]
    of_terms = np.zeros((tables.n_control_points, tables.n_control_points, n_triangles))
    if terms != STIFFNESS:
        of_terms += np.einsum("qn,qa,qb->abn", c0, phi, phi, optimize=True)
    if terms != MASS:
        for c, left, right in ((c1, d1, d1), (c2, d1, d2), (c2, d2, d1), (c3, d2, d2)):
            of_terms += np.einsum("qn,qa,qb->abn", c, left, right, optimize=True)
    a, b = tables.pairs
    np.testing.assert_allclose(local, of_terms[a, b], rtol=0, atol=1e-11 * np.abs(local).max())
    n_distinct = tables._distinct[0].shape[-1]
    assert n_distinct < 40 < tables.n_control_points


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_matrices_do_not_depend_on_which_classes_are_rare(tolerance, monkeypatch):
    vertices, faces = meshes.random_closed(4)
    topology = TriangleTopology(faces, len(vertices))

    def everything(few):
        monkeypatch.setattr(table_cache, "FEW_TRIANGLES", few)
        space = LoopSpace(topology, tolerance)
        system = space.step_system(vertices, timestep=np.linspace(1, 2, len(vertices)))
        measures = system.measures
        return (
            system.matrix.full().toarray(),
            system.load,
            np.array([measures.curvature_energy, measures.area, measures.volume]),
        )

    for alone, joined in zip(everything(0), everything(1000), strict=True):
        np.testing.assert_allclose(joined, alone, rtol=1e-11, atol=1e-13 * np.abs(alone).max())
