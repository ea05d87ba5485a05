"""Report of a run as strict JSON: all settings and all measures.

Lengths, areas and volumes are in object units of the mesh. Times and densities are those of the
solver's [-3, 3]^3 frame. A value that does not exist, such as the volume of an open surface, is
null.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core import (
    DenoiseResult,
    DenoiseSettings,
    FairingSettings,
    FairingStep,
    SolveReport,
    SurfaceMeasures,
)
from ..core.diffusion.settings import DENSITIES, SCHEMES
from ..core.fem.differential_geometry import energy_ratio
from .atomic_files import replaced_file

Json = dict[str, Any]


def settings_record(settings: DenoiseSettings | FairingSettings) -> Json:
    """Record of the algorithm and its settings, in the words of the command line.

    `settings_of_record` reads it back.
    """
    values = asdict(settings)
    if isinstance(settings, DenoiseSettings):
        return {"algorithm": "denoise", "settings": values}
    scheme, density = values.pop("method"), values.pop("density")
    words = {"scheme": _word_of(scheme, SCHEMES), "density": _word_of(density, DENSITIES)}
    return {"algorithm": "fair", "settings": {**words, **values}}


def settings_of_record(record: Mapping[str, Any]) -> DenoiseSettings | FairingSettings:
    """Read a `settings_record`; a missing setting takes its default.

    Raises
    ------
    SettingsError
        A value is invalid.
    """
    values = dict(record["settings"])
    if record["algorithm"] == "denoise":
        return DenoiseSettings(**values)
    if "scheme" in values:
        values["method"] = SCHEMES[values.pop("scheme")]
    if "density" in values:
        values["density"] = DENSITIES[values["density"]]
    return FairingSettings(**values)


def _word_of(value: str, words: Mapping[str, str]) -> str:
    return next(word for word, meaning in words.items() if meaning == value)


def step_record(step: FairingStep, start: ArrayLike, seconds: float) -> Json:
    """Record of one step of the paper's diffusion.

    Parameters
    ----------
    step
        Step as the solver yielded it.
    start
        (n, 3) positions of the input; displacements are measured from them.
    seconds
        Time that the step took; the first step includes the set-up of the solver.
    """
    return {
        "step": step.index,
        "tau": step.tau,
        "time": step.time,
        "seconds": seconds,
        **_solve_record(step.solve),
        "curvature_energy": step.curvature_energy,
        "curvature_ratio": step.curvature_ratio,
        "area": step.area,
        "volume": step.volume,
        **_displacement_record(step.positions, start),
    }


def denoise_record(result: DenoiseResult, seconds: float) -> Json:
    """Record of a run of `denoise`: its estimates, and one entry for every strength."""
    return {
        "seconds": seconds,
        "is_changed": result.is_changed,
        "noise": result.noise_level,
        "noise_length": result.noise_length,
        "radius": result.radius,
        "sharp_part": result.sharp_part,
        "crease_part": result.crease_part,
        "is_sharp": result.is_sharp,
        **_solve_record(result.solve),
        "chosen": result.chosen,
        "strengths": [
            {
                "strength": strength,
                **asdict(measures),
                "curvature_ratio": energy_ratio(
                    measures.curvature_energy, result.initial.curvature_energy
                ),
                **_displacement_record(shape, result.start),
            }
            for strength, measures, shape in zip(
                result.strengths, result.measures, result.shapes, strict=True
            )
        ],
    }


def _solve_record(solve: SolveReport) -> Json:
    return {
        "cg_iterations": solve.iterations,
        "cg_residual": solve.residual,
        "converged": solve.converged,
    }


def _displacement_record(positions: ArrayLike, start: ArrayLike) -> Json:
    displacement = np.linalg.norm(np.asarray(positions) - np.asarray(start), axis=1)
    return {
        "largest_displacement": displacement.max(initial=0.0),
        "mean_displacement": displacement.mean() if len(displacement) else 0.0,
    }


def build_report(
    *,
    settings: FairingSettings | DenoiseSettings,
    program: Mapping[str, Any],
    files: Mapping[str, Any],
    mesh: Mapping[str, Any],
    written: Mapping[str, Any],
    initial: SurfaceMeasures | None,
    denoise: Json | None,
    steps: Sequence[Json],
    stop_reason: str | None,
    notes: Sequence[str],
    error: str | None,
) -> Json:
    """Build the report of a run.

    Parameters
    ----------
    settings
        Settings of the algorithm.
    program
        Names and versions of what ran.
    files
        Input, output and object.
    mesh, written
        Counts of the mesh that was read and of the mesh that was written; empty without one.
    initial
        Measures of the input surface; None if the run ended before its first step.
    denoise
        A `denoise_record`, if `denoise` was run.
    steps
        A `step_record` for each step of the paper's diffusion.
    stop_reason
        Why the run ended, as in `FairingStep`; None if an error ended it.
    notes
        Faults of the input and losses in the output, one sentence each.
    error
        The error message; None if all went well.
    """
    return {
        "program": dict(program),
        **files,
        **settings_record(settings),
        "mesh": dict(mesh),
        "written": dict(written),
        "initial": None if initial is None else asdict(initial),
        "denoise": denoise,
        "steps": list(steps),
        "stop_reason": stop_reason,
        "notes": list(notes),
        "error": error,
    }


def write_report(path: str | os.PathLike[str], report: Mapping[str, Any]) -> None:
    """Write the report; an earlier file of that name is replaced as a whole or left unchanged.

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
    """Convert a value for strict JSON: numbers that are not finite become null."""
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
