"""The main job when it fails: what is told, what is written, and what is left alone."""

import errno
import json
import os
from pathlib import Path

import bpy
import pytest
from support.meshes import random_closed
from support.objects import (
    write_ply,
)

from adaptive_fairing.blender.files.mesh_files import import_mesh, save_blend
from adaptive_fairing.blender.jobs.file_job import FairingJob, run_job
from adaptive_fairing.core import (
    DenoiseSettings,
    FairingError,
    FairingSettings,
    SolverError,
    TopologyError,
)

HOPELESS = FairingSettings(cg_max_iterations=1, cg_tolerance=1e-12)


@pytest.fixture
def noisy(tmp_path):
    return write_ply(tmp_path / "noisy.ply", *random_closed(seed=1))


def test_a_solve_that_fails_at_once_writes_nothing_but_the_report(noisy, tmp_path):
    job = FairingJob(noisy, tmp_path / "out.blend", HOPELESS, report=tmp_path / "report.json")
    with pytest.raises(
        SolverError, match=r"step 1 did not converge: residual \S+ after 1 iterations.*no output"
    ):
        run_job(job)
    assert not job.output.exists()
    written = json.loads(job.report.read_text())
    assert written["stop_reason"] == "not_converged"
    assert written["steps"][0]["converged"] is False
    assert written["error"].startswith("step 1 did not converge")


def test_sculpted_levels_are_not_left_above_a_changed_base(noisy, tmp_path):
    obj = import_mesh(noisy)
    bpy.context.view_layer.objects.active = obj
    modifier = obj.modifiers.new("Levels", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier=modifier.name)
    save_blend(tmp_path / "sculpture.blend")
    job = FairingJob(tmp_path / "sculpture.blend", tmp_path / "out.blend", DenoiseSettings())
    with pytest.raises(FairingError, match=r"has sculpted levels.*apply the multiresolution"):
        run_job(job)
    assert not job.output.exists()


def failing_at(step_number, monkeypatch, kind):
    """Let the solver fail at a step, after real steps before it."""
    from adaptive_fairing.blender.jobs import solve

    real = solve.fair_steps

    def steps(vertices, faces, settings, **options):
        for step in real(vertices, faces, settings, **options):
            if step.index == step_number:
                if kind == "raises":
                    raise SolverError("the linear system is broken")
                hopeless = FairingSettings(**{**vars(settings), "cg_max_iterations": 1})
                failed = next(real(vertices, faces, hopeless))
                step = type(step)(
                    **{**vars(step), "solve": failed.solve, "stop_reason": "not_converged"}
                )
            yield step

    monkeypatch.setattr(solve, "fair_steps", steps)


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("raises", "the linear system is broken"),
        ("misses", r"step 3 did not converge: residual \S+ after 1 iterations"),
    ],
)
def test_a_solve_that_fails_later_keeps_the_steps_before(
    noisy, tmp_path, monkeypatch, kind, message
):
    failing_at(3, monkeypatch, kind)
    settings = FairingSettings(tau=0.005, steps=4)
    with pytest.raises(SolverError, match=f"{message}.*the 2 before it are in .*out.blend"):
        run_job(FairingJob(noisy, tmp_path / "out.blend", settings))
    keys = import_mesh(tmp_path / "out.blend").data.shape_keys
    assert [block.name for block in keys.key_blocks] == ["Basis", "Fairing 1", "Fairing 2"]


def test_a_surface_that_the_core_refuses_is_reported(noisy, tmp_path, monkeypatch):
    def refuse(*arguments, **options):
        raise TopologyError("3 edges belong to more than two triangles")

    monkeypatch.setattr("adaptive_fairing.blender.jobs.solve.fair_steps", refuse)
    job = FairingJob(
        noisy, tmp_path / "out.blend", FairingSettings(), report=tmp_path / "report.json"
    )
    with pytest.raises(TopologyError):
        run_job(job)
    assert not job.output.exists()
    written = json.loads(job.report.read_text())
    assert written["error"] == "3 edges belong to more than two triangles"
    assert written["mesh"]["triangles"] == 80
    assert written["steps"] == []
    assert written["initial"] is None
    assert written["stop_reason"] is None


def test_an_unwritable_place_is_found_before_the_work(noisy, tmp_path):
    seen = []
    for job in (
        FairingJob(noisy, tmp_path / "no" / "out.ply"),
        FairingJob(noisy, tmp_path / "out.ply", report=tmp_path / "no" / "report.json"),
    ):
        with pytest.raises(OSError, match="its folder does not exist"):
            run_job(job, seen.append)
    assert not seen


def test_a_point_cloud_has_nothing_to_fair(tmp_path):
    path = tmp_path / "points.ply"
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n1 1 1\n"
    )
    with pytest.raises(FairingError, match=r"'points' in points\.ply has no faces"):
        run_job(FairingJob(path, tmp_path / "out.ply"))


@pytest.mark.parametrize("suffix", [".blend", ".ply"])
def test_an_output_that_another_program_has_open_stays(noisy, tmp_path, monkeypatch, suffix):
    """As on Windows, where it cannot be replaced: one line, a report, no drafts."""
    real = os.replace

    def replace(draft, final):
        if Path(final).suffix == suffix:
            raise PermissionError(errno.EACCES, "Access is denied", str(draft), 5, str(final))
        real(draft, final)

    monkeypatch.setattr(os, "replace", replace)
    output, report = tmp_path / f"out{suffix}", tmp_path / "report.json"
    output.write_text("old")
    with pytest.raises(OSError, match=r"^cannot write .*: Access is denied; close it in other"):
        run_job(FairingJob(noisy, output, FairingSettings(steps=1), report=report))
    assert output.read_text() == "old"
    assert "Access is denied" in json.loads(report.read_text())["error"]
    assert sorted(tmp_path.iterdir()) == sorted([noisy, output, report])
