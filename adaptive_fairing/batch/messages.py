"""Messages between a batch and its worker processes: one JSON object a line.

A worker's standard output also carries what Blender prints, so messages have a mark in front.

    batch to worker    {"job": {...}}                what to do: the fields of `Job`
                       {"answer": "go" | "later"}    to "needs"
    worker to batch    {"event": "needs", "bytes": n}
                       {"event": "later"}            the mesh was put aside
                       {"event": "done", ...}        {"event": "failed", "error": "..."}
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

MARK = "@adaptive-fairing "


@dataclass(frozen=True)
class Job:
    """One mesh to fair, or to measure.

    Attributes
    ----------
    input, frame, object_name
        As in `FairingJob`.
    settings
        A `settings_record`.
    output
        File to write; None only measures what frames of one strength have in common.
    reference
        File and frame of the mesh whose analysis serves this one too; None for none.
    scale
        As in `PreparedMesh`.
    refine
        As in `FairingJob`.
    """

    input: str
    frame: int | None
    object_name: str | None
    settings: dict[str, Any]
    output: str | None
    reference: tuple[str, int | None] | None = None
    scale: float | None = None
    refine: int | None = None

    def message(self) -> dict[str, Any]:
        """Write the job as a message."""
        return {"job": asdict(self)}

    @classmethod
    def of(cls, message: dict[str, Any]) -> Job:
        """Read the message."""
        return cls(**message["job"])


def encode(message: dict[str, Any]) -> str:
    """Write a message as a line of its own, even if Blender has left one unfinished."""
    return f"\n{MARK}{json.dumps(message)}\n"


def decode(line: str) -> dict[str, Any] | None:
    """Read a line; None if it is no message."""
    return json.loads(line[len(MARK) :]) if line.startswith(MARK) else None
