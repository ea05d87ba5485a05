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
        As the run that made or tried it has left it; None if there is none.
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
    """Take what a report says of the result: of the strength asked for, or of the last step."""
    found = report.get("denoise")
    if found is not None:
        return {**found, **found["strengths"][found["chosen"]]}
    return (report.get("steps") or [{}])[-1]


def summary(
    entries: Sequence[Json], *, version: str, algorithm: Json, arguments: Json, seconds: float
) -> Json:
    """Put the account of a batch together.

    Parameters
    ----------
    entries
        One `mesh_entry` each.
    version
        Of the program.
    algorithm
        With its settings, see `settings_record`.
    arguments
        What else was asked for.
    seconds
        Time that this run took.
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
