"""Summary of a batch as JSON: the outcome of each mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .plan import Item

Json = dict[str, Any]

DONE, SKIPPED, FAILED, MISSING = "done", "skipped", "failed", "missing"
"""Made now; finished by an earlier run; not made, with an error; not tried yet (`--merge`)."""


def mesh_entry(item: Item, status: str, record: Json | None) -> Json:
    """Describe one mesh.

    Parameters
    ----------
    item
        The mesh.
    status
        One of the constants of this module.
    record
        Written by the run that made the output or failed to; None without one.
    """
    record = record or {}
    report = record.get("report") or {}
    steps = report.get("steps", [])
    outcome = outcome_of(report)
    return {
        "output": item.name,
        "input": str(item.input),
        "frame": item.number,
        "status": status,
        "error": record.get("error"),
        "vertices": report.get("mesh", {}).get("vertices"),
        "triangles": report.get("mesh", {}).get("triangles"),
        "steps": len(steps),
        "tau": outcome.get("tau"),
        "stop_reason": report.get("stop_reason"),
        "curvature_ratio": outcome.get("curvature_ratio"),
        "largest_displacement": outcome.get("largest_displacement"),
        "noise": outcome.get("noise"),
        "radius": outcome.get("radius"),
        "notes": report.get("notes", []),
        "seconds": record.get("seconds"),
        "needed_bytes": record.get("needed_bytes"),
        "peak_bytes": record.get("peak_bytes"),
    }


def outcome_of(report: Json) -> Json:
    """Measures of the result in a report: at the chosen strength, or after the last step."""
    found = report.get("denoise")
    if found is not None:
        return {**found, **found["strengths"][found["chosen"]]}
    return (report.get("steps") or [{}])[-1]


def summary(
    entries: Sequence[Json], *, version: str, algorithm: Json, arguments: Json, seconds: float
) -> Json:
    """Build the account of a batch.

    Parameters
    ----------
    entries
        One `mesh_entry` each.
    version
        Version of the program.
    algorithm
        Algorithm with its settings, as in `settings_record`.
    arguments
        All other options of the run.
    seconds
        Duration of this run.
    """
    statuses = [entry["status"] for entry in entries]
    return {
        "program": {"name": "adaptive-fairing", "version": version},
        **algorithm,
        **arguments,
        "seconds": seconds,
        "counts": {"meshes": len(entries)}
        | {status: statuses.count(status) for status in (DONE, SKIPPED, FAILED, MISSING)},
        "meshes": list(entries),
    }


def is_complete(entries: Sequence[Json]) -> bool:
    """Whether every mesh has its output."""
    return all(entry["status"] in (DONE, SKIPPED) for entry in entries)
