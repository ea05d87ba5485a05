"""The report: strict JSON, written whole."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from support.meshes import bumpy_disc, noisy_ball

from adaptive_fairing.core import DenoiseSettings, FairingSettings, denoise, fair
from adaptive_fairing.files.report import (
    build_report,
    denoise_record,
    step_record,
    strict,
    write_report,
)


def test_what_json_cannot_hold_becomes_what_it_can():
    value = {
        "nan": math.nan,
        "infinite": [math.inf, -math.inf, np.float32("nan")],
        "numpy": (np.float64(0.5), np.int32(3), np.bool_(True)),
        "array": np.array([[1.0, np.nan]]),
        "path": Path("a") / "b.ply",
        1: None,
    }
    assert strict(value) == {
        "nan": None,
        "infinite": [None, None, None],
        "numpy": [0.5, 3, True],
        "array": [[1.0, None]],
        "path": str(Path("a") / "b.ply"),
        "1": None,
    }


def test_numbers_survive_to_the_last_bit(tmp_path):
    numbers = [0.1, 1e-300, 2 / 3, 1e22]
    write_report(tmp_path / "report.json", {"numbers": numbers})
    assert json.loads((tmp_path / "report.json").read_text())["numbers"] == numbers


def test_names_in_any_script_are_readable(tmp_path):
    write_report(tmp_path / "report.json", {"object": "頭部"})
    assert "頭部" in (tmp_path / "report.json").read_text(encoding="utf-8")


def test_a_report_that_fails_leaves_the_old_one(tmp_path):
    path = tmp_path / "report.json"
    path.write_text("old")
    with pytest.raises(TypeError):
        write_report(path, {"what": object()})
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_displacements_are_measured_from_the_input():
    vertices, faces = bumpy_disc(seed=0)
    last = fair(vertices, faces, FairingSettings(tau=0.016, steps=3)).steps[-1]
    record = step_record(last, vertices, 1.5)
    moved = np.linalg.norm(last.positions - vertices, axis=1)
    assert record["largest_displacement"] == moved.max() > 0
    assert record["mean_displacement"] == moved.mean()
    assert record["seconds"] == 1.5
    assert record["tau"] == 0.016
    assert record["time"] == 3 * 0.016


def test_denoising_is_recorded_with_every_strength():
    vertices, faces = noisy_ball(3, 0.01)
    result = denoise(vertices, faces)
    record = denoise_record(result, 1.5)
    assert record["noise"] == result.noise_level > 0
    assert [each["strength"] for each in record["strengths"]] == [0.5, 0.75, 1.0, 1.5, 2.0]
    chosen = record["strengths"][record["chosen"]]
    moved = np.linalg.norm(result.positions - vertices, axis=1)
    assert chosen["largest_displacement"] == moved.max() > 0
    assert chosen["area"] == result.measures[result.chosen].area
    json.dumps(strict(record), allow_nan=False)


@pytest.mark.parametrize(
    ("settings", "algorithm"), [(FairingSettings(), "fair"), (DenoiseSettings(), "denoise")]
)
def test_a_run_that_never_started_is_reported_too(settings, algorithm):
    report = build_report(
        settings=settings,
        program={"name": "x"},
        files={"input": "in", "output": "out", "object": None},
        mesh={},
        written={},
        initial=None,
        denoise=None,
        steps=[],
        stop_reason=None,
        notes=[],
        error="no such file",
    )
    assert report["error"] == "no such file"
    assert report["initial"] is None
    assert report["algorithm"] == algorithm
    assert report["settings"]["boundary"] == "fixed"
    json.dumps(strict(report), allow_nan=False)
