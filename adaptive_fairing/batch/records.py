"""Records beside outputs: settings and input of a finished result, for a later run.

An output counts as finished if its record says so and nothing has changed since: the version of the
program, the settings, object, frame and format; size and modification time of the input, of the
files that belong to it, and of the output itself. A sequence with one strength also compares the
input that the strength comes from. Any other output is made again.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..files.report import strict, write_report
from .summary import DONE, FAILED

Json = dict[str, Any]

COMPANIONS = (".bin", ".mtl")
"""Suffixes of files that belong to a file and have its name."""


def stamp(path: Path) -> Json | None:
    """Size and modification time of a file; None if it does not exist."""
    try:
        status = path.stat()
    except OSError:
        return None
    return {"size": status.st_size, "modified_ns": status.st_mtime_ns}


def input_stamp(path: Path) -> Json:
    """Stamps of an input and of the files that belong to it."""
    belonging = [path.with_suffix(suffix) for suffix in COMPANIONS]
    return {each.name: stamp(each) for each in (path, *belonging) if each.exists()}


def read_record(path: Path) -> Json | None:
    """Read a record; None if it does not exist or cannot be read."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return record if isinstance(record, dict) else None


def is_finished(record: Json | None, made_with: Mapping[str, Any], output: Path) -> bool:
    """Whether an output exists and was made from these inputs with these settings.

    Parameters
    ----------
    record
        As `read_record` returned it.
    made_with
        Inputs and settings of the run that asks.
    output
        The file.
    """
    return (
        record is not None
        and _says(record, DONE, made_with)
        and record.get("output_stamp") is not None
        and record["output_stamp"] == stamp(output)
    )


def has_failed(record: Json | None, made_with: Mapping[str, Any]) -> bool:
    """Whether an earlier run failed to make an output from these inputs with these settings."""
    return _says(record, FAILED, made_with)


def _says(record: Json | None, status: str, made_with: Mapping[str, Any]) -> bool:
    return (
        record is not None
        and record.get("status") == status
        and record.get("made_with") == strict(made_with)
    )


def write_record(
    path: Path, *, status: str, made_with: Mapping[str, Any], output: Path, account: Json
) -> Json:
    """Write the outcome of an output, after the output itself, and return the record.

    Parameters
    ----------
    path
        File of the record; its folder is made if it is missing.
    status
        `DONE` or `FAILED`, see `summary`.
    made_with
        As for `is_finished`.
    output
        The file; None if it was not made.
    account
        Error, report and numbers of the run.
    """
    record = {
        "status": status,
        "output_stamp": stamp(output) if status == DONE else None,
        "made_with": dict(made_with),
        **account,
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    write_report(path, record)
    return record
