"""From press to press: the set-up of a mesh is made once, as long as its triangles stay."""

import numpy as np
import pytest
from support.meshes import noisy_ball, torus

from adaptive_fairing.blender.jobs import kept_preparation
from adaptive_fairing.blender.jobs.kept_preparation import KeptPreparation
from adaptive_fairing.blender.jobs.solve import Solve
from adaptive_fairing.core import DenoiseSettings, FairingSettings, LoopSpace, TriangleTopology
from adaptive_fairing.core.mesh import solver_mesh
from adaptive_fairing.core.problem import prepared_surface

VERTICES, FACES = noisy_ball(3, 0.03)


@pytest.fixture
def made(monkeypatch):
    """Sizes of the topologies and of the finite element spaces that are made."""
    topologies, spaces = [], []

    def topology(faces, n_vertices):
        topologies.append(len(faces))
        return TriangleTopology(faces, n_vertices)

    def space(topology, *given):
        spaces.append(topology.n_triangles)
        return LoopSpace(topology, *given)

    monkeypatch.setattr(solver_mesh, "TriangleTopology", topology)
    monkeypatch.setattr(prepared_surface, "LoopSpace", space)
    return topologies, spaces


def press(kept, vertices, faces, settings, weights=None):
    solve = Solve(vertices, faces, settings, weights, preparations=kept)
    for _ in solve.run():
        pass
    return solve


def test_other_settings_and_other_positions_need_no_set_up(made):
    kept, positions = KeptPreparation(), VERTICES
    for settings in (
        FairingSettings(steps=1),
        FairingSettings(method="adaptive_tensor", tau=0.01, steps=2),
        DenoiseSettings(),
    ):
        positions = press(kept, positions, FACES, settings).positions.astype(float)
    assert made == ([len(FACES)], [len(FACES)])


def test_a_stroke_elsewhere_prepares_its_part_alone(made):
    kept = KeptPreparation()
    for end in (0, 1, 1):
        weights = np.linalg.norm(VERTICES - VERTICES[end], axis=1) < 0.2
        press(kept, VERTICES, FACES, FairingSettings(steps=1), weights.astype(float))
    topologies, spaces = made
    assert topologies[0] == len(FACES)
    assert topologies[1:] == spaces
    assert len(spaces) == 2
    assert max(spaces) < len(FACES) / 3


def test_the_result_is_that_without_help():
    """But for the last bits: the order of the vertices is that of the first shape."""
    kept = KeptPreparation()
    press(kept, VERTICES[:, [1, 2, 0]], FACES, FairingSettings(steps=1))
    settings = FairingSettings(steps=2, cg_tolerance=1e-12)
    alone, helped = (press(each, VERTICES, FACES, settings).positions for each in (None, kept))
    np.testing.assert_allclose(helped, alone, rtol=0, atol=1e-6)


def test_other_triangles_and_another_quadrature_are_prepared_anew(made):
    kept = KeptPreparation()
    settings = FairingSettings(steps=1)
    finer = FairingSettings(steps=1, quadrature_tolerance=1e-4)
    other = torus(20, 12)
    for vertices, faces, each in (
        (VERTICES, FACES, settings),
        (VERTICES, FACES[:, [1, 2, 0]], settings),
        (*other, settings),
        (*other, finer),
    ):
        press(kept, vertices, faces, each)
    assert made[0] == [len(FACES), len(FACES), len(other[1]), len(other[1])]


def test_of_a_large_mesh_only_the_connectivity_is_kept(made, monkeypatch):
    monkeypatch.setattr(kept_preparation, "LARGEST_KEPT", len(FACES) - 1)
    kept = KeptPreparation()
    for _ in range(2):
        press(kept, VERTICES, FACES, FairingSettings(steps=1))
    assert made == ([len(FACES)], [len(FACES)] * 2)
