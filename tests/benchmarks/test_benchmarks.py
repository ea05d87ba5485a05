"""The benchmarks: their meshes, their clock, their history. No test looks at how long things take.

The profile also fails here when a function of the core that it times has been renamed.
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from adaptive_fairing.core import FairingSettings, TriangleTopology
from adaptive_fairing.core.diffusion import steps
from adaptive_fairing.core.fem import loop_space

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def load(monkeypatch: pytest.MonkeyPatch):
    """Import a module of the benchmarks, whose scripts know each other by their bare names."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    before = set(sys.modules)

    def module(name: str) -> ModuleType:
        return importlib.import_module(name)

    yield module
    for name in set(sys.modules) - before:
        if getattr(sys.modules[name], "__file__", "").startswith(str(BENCHMARKS)):
            del sys.modules[name]


@pytest.mark.parametrize("shape", ["sphere", "irregular"])
def test_meshes_are_closed_and_oriented_and_fill_the_frame(load, shape):
    mesh = getattr(load("meshes"), shape)(2000)
    topology = TriangleTopology(mesh.triangles, len(mesh.vertices))
    assert topology.is_closed
    assert len(mesh.vertices) - len(mesh.triangles) / 2 == 2  # Euler: one sphere-like piece
    corner = mesh.vertices[mesh.triangles]
    assert np.einsum("fd,fd->f", np.cross(corner[:, 0], corner[:, 1]), corner[:, 2]).sum() > 0
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(6, rel=0.1)  # the noise comes last
    n_valences = len(np.unique(topology.ring_size))
    assert n_valences == 2 if shape == "sphere" else n_valences > 5


def test_mesh_files_keep_every_bit(load, tmp_path):
    meshes = load("meshes")
    mesh = meshes.irregular(500)
    meshes.write_ply(mesh, tmp_path / "mesh.ply")
    again = meshes.read_ply(tmp_path / "mesh.ply")
    np.testing.assert_array_equal(again.vertices, mesh.vertices)
    np.testing.assert_array_equal(again.triangles, mesh.triangles)


def test_many_classes_come_as_asked_for(load):
    small = load("small")
    mesh = small.with_classes(3000, 200)
    assert abs(len(mesh.triangles) - 3000) <= 1
    assert TriangleTopology(mesh.triangles, len(mesh.vertices)).is_closed
    assert 180 <= small._count_classes(mesh) <= 220


def test_profile_accounts_for_every_stage_and_puts_the_core_back(load):
    profile_step, stages = load("profile_step"), load("stages")
    functions = loop_space.evaluate, loop_space.ordered_map, steps.conjugate_gradients
    mesh = load("meshes").irregular(40_000)  # several chunks: some stages run in threads
    profiles = [profile_step.profile(mesh, FairingSettings()) for _ in range(3)]
    for part, expected in (("setup", stages.SETUP), ("step", stages.STEP)):
        labels = [*dict.fromkeys(stage.label for stage in expected), profile_step.REST]
        found = [getattr(profile, part) for profile in profiles]
        for each in found:
            assert list(each.seconds) == list(each.processor) == labels
            assert min(each.seconds[label] for label in labels[:-1]) > 0
        # What is left over is small, so nothing is counted twice and nothing large is forgotten;
        # in one run of three, as other programs may stop this one anywhere.
        assert min(abs(each.seconds[profile_step.REST]) / each.total for each in found) < 0.2
    assert functions == (loop_space.evaluate, loop_space.ordered_map, steps.conjugate_gradients)


def test_history_warns_of_a_ratio_above_the_median_of_comparable_runs(load, tmp_path):
    history = load("history")
    path = tmp_path / "history.jsonl"
    here, elsewhere = {"processor": "A", "cores": 2}, {"processor": "B", "cores": 2}
    for ratio in (9.0, 1.0, 1.1, 0.9, 1.0, 7.0):  # the last five have the median 1
        history.append(path, "speed", here, {"step": ratio})
    history.append(path, "speed", elsewhere, {"step": 0.1})
    history.append(path, "small", here, {"step": 0.1})
    runs = history.read(path)
    assert len(runs) == 8
    assert runs[0]["ratios"] == {"step": 9.0}
    assert history.regressions(runs, "speed", here, {"step": 1.19, "new": 5.0}) == []
    (warning,) = history.regressions(runs, "speed", here, {"step": 1.21})
    assert warning.startswith("step: 1.21, was 1 ")


def test_commands_print_tables(load):
    load("measuring")
    commands = [
        ["small.py", "--sizes", "500", "--classes", "20", "--repeats", "1"],
        ["profile_step.py", "--sizes", "500", "--repeats", "1"],
        ["speed.py", "--sizes", "500", "--repeats", "1", "--programs", "Adaptive Fairing"],
    ]
    for script, *options in commands:
        command = [sys.executable, str(BENCHMARKS / script), *options]
        # The scripts measure the package of this checkout, installed or not.
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": str(BENCHMARKS.parent)},
        )
        assert done.returncode == 0, done.stderr
        assert done.stdout.count("| ---") >= 1
