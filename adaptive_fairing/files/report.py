"""The report of a run: everything that was asked for and measured, as strict JSON.

Lengths, areas and volumes are in object units of the mesh; times and densities are those of the
solver's [-3, 3]^3 frame. What has no value (the volume of an open surface) is null.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.denoise.plan import AutoEstimate
from ..core.fem.differential_geometry import SurfaceMeasures
from ..core.results import FairingStep
from ..core.settings import FairingSettings
from .atomic_files import replaced_file

Json = dict[str, Any]


def step_record(step: FairingStep, start: ArrayLike, seconds: float) -> Json:
    """Describe one step.

    Parameters
    ----------
    step
        As the solver yielded it.
    start
        (n, 3) positions of the input, which displacements are measured from.
    seconds
        Time that the step took; the first step includes the set-up of the solver.
    """
    displacement = np.linalg.norm(step.positions - np.asarray(start), axis=1)
    return {
        "step": step.index,
        "time": step.time,
        "seconds": seconds,
        "cg_iterations": step.solve.iterations,
        "cg_residual": step.solve.residual,
        "converged": step.solve.converged,
        "curvature_energy": step.curvature_energy,
        "curvature_ratio": step.curvature_ratio,
        "area": step.area,
        "volume": step.volume,
        "largest_displacement": displacement.max(initial=0.0),
        "mean_displacement": displacement.mean() if len(displacement) else 0.0,
        "auto": None if step.auto is None else _estimate_record(step.auto),
    }


def _estimate_record(estimate: AutoEstimate) -> Json:
    """All of an estimate but the plan, which is as large as the mesh."""
    return {
        field.name: getattr(estimate, field.name)
        for field in fields(estimate)
        if field.name != "plan"
    }


def build_report(
    *,
    settings: FairingSettings,
    program: Mapping[str, Any],
    files: Mapping[str, Any],
    mesh: Mapping[str, Any],
    initial: SurfaceMeasures | None,
    steps: Sequence[Json],
    stop_reason: str | None,
    notes: Sequence[str],
    error: str | None,
) -> Json:
    """Put the report of a run together.

    Parameters
    ----------
    settings
        As the solver got them.
    program
        Names and versions of what ran.
    files
        Input, output and object.
    mesh
        Counts of the mesh; empty if it could not be read.
    initial
        Measures of the input surface; None if the run did not reach its first step.
    steps
        One `step_record` each.
    stop_reason
        Why the run ended, as in `FairingStep`; None if an error ended it.
    notes
        What was wrong with the input and what the output could not hold, one sentence each.
    error
        The error message; None if all went well.
    """
    return {
        "program": dict(program),
        **files,
        "settings": asdict(settings),
        "mesh": dict(mesh),
        "initial": None if initial is None else asdict(initial),
        "steps": list(steps),
        "stop_reason": stop_reason,
        "notes": list(notes),
        "error": error,
    }


def write_report(path: str | os.PathLike[str], report: Mapping[str, Any]) -> None:
    """Write the report; an earlier file of that name is replaced in one go or left as it was.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    text = json.dumps(strict(report), indent=2, ensure_ascii=False, allow_nan=False)
    with replaced_file(path) as draft:
        # A name that is no UTF-8 has surrogates; written this way they are JSON, too.
        draft.write_text(text + "\n", encoding="utf-8", errors="backslashreplace")


def strict(value: Any) -> Any:
    """Turn a value into what strict JSON can hold: numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): strict(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return strict(value.tolist())
    if isinstance(value, (list, tuple)):
        return [strict(item) for item in value]
    if isinstance(value, np.generic):
        return strict(value.item())
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
