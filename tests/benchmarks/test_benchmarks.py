"""The benchmarks: their meshes and the profile. No test looks at how long things take."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from adaptive_fairing.core import FairingSettings, TriangleTopology, mesh_density
from benchmarks import meshes, profile_step

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("shape", ["sphere", "irregular"])
def test_meshes_are_closed_and_oriented_and_fill_the_frame(shape):
    mesh = meshes.SHAPES[shape](2000)
    topology = TriangleTopology(mesh.triangles, len(mesh.vertices))
    assert topology.is_closed
    assert len(mesh.vertices) - len(mesh.triangles) / 2 == 2  # Euler: one sphere-like piece
    corner = mesh.vertices[mesh.triangles]
    assert np.einsum("fd,fd->f", np.cross(corner[:, 0], corner[:, 1]), corner[:, 2]).sum() > 0
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(6, rel=0.1)  # the noise comes last
    n_valences = len(np.unique(topology.ring_size))
    assert n_valences == 2 if shape == "sphere" else n_valences > 5


def test_mesh_files_keep_every_bit(tmp_path):
    mesh = meshes.irregular(500)
    mesh.write(tmp_path / "mesh.ply")
    again = meshes.read(tmp_path / "mesh.ply")
    np.testing.assert_array_equal(again.vertices, mesh.vertices)
    np.testing.assert_array_equal(again.triangles, mesh.triangles)


def test_many_classes_come_as_asked_for():
    mesh = meshes.many_classes(3000, 200)
    assert abs(len(mesh.triangles) - 3000) <= 1
    assert TriangleTopology(mesh.triangles, len(mesh.vertices)).is_closed
    assert 180 <= meshes.count_classes(mesh) <= 220


def test_the_profile_sees_the_module_that_works_and_no_other():
    mesh = meshes.irregular(20_000)
    topology = TriangleTopology(mesh.triangles, len(mesh.vertices))

    def work() -> int:
        end = time.monotonic() + 0.3
        while time.monotonic() < end:
            mesh_density(topology, mesh.vertices, "edge_length", 3)
        return 7

    before = threading.active_count()
    result, found = profile_step.profile(work)
    assert result == 7
    assert found.seconds >= 0.3
    assert found.looks["mesh.density"] > 0
    assert {name.partition(".")[0] for name in found.looks} == {"mesh"}
    assert threading.active_count() == before


def test_the_profile_of_a_step_finds_the_solver_and_the_elements():
    mesh = meshes.irregular(40_000)
    settings = meshes.comparable_settings(mesh, 2.0)
    (first, second, denoised), iterations = profile_step.profiles(mesh, settings)
    assert {"linalg", "fem"} <= {name.partition(".")[0] for name in second.looks}
    assert {"loop", "mesh"} <= {name.partition(".")[0] for name in first.looks}
    assert {"linalg", "denoising"} <= {name.partition(".")[0] for name in denoised.looks}
    assert iterations > 0
    assert profile_step.unavoidable_work(mesh, FairingSettings(), iterations).operations > 0


@pytest.mark.parametrize(
    "options",
    [
        ["profile_step", "--sizes", "500", "--repeats", "1"],
        ["speed", "--sizes", "500", "--repeats", "1", "--programs", "Adaptive Fairing"],
        ["memory", "irregular"],
    ],
)
def test_commands_print_tables(options):
    command = [sys.executable, "-m", f"benchmarks.{options[0]}", *options[1:]]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("| ---") >= 1
