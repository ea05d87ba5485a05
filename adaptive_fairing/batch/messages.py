"""Messages between a batch and its worker processes: one JSON object a line.

Blender prints to a worker's standard output as well, so each message begins with a mark.

    batch to worker    {"job": {...}}                what to do: the fields of `Job`
                       {"answer": "go" | "later"}    to "needs"
    worker to batch    {"event": "needs", "bytes": n}
                       {"event": "later"}            the mesh was postponed
                       {"event": "done", ...}        {"event": "failed", "error": "..."}
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

MARK = "@adaptive-fairing "


@dataclass(frozen=True)
class Job:
    """One mesh to process or to measure.

    Attributes
    ----------
    input, frame, object_name
        As in `FairingJob`.
    settings
        A `settings_record`.
    output
        File to write; None to measure only what all frames of one strength share.
    reference
        File and frame of the mesh whose analysis this mesh uses too; None for its own analysis.
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
        """Message that carries the job."""
        return {"job": asdict(self)}

    @classmethod
    def of(cls, message: dict[str, Any]) -> Job:
        """Read the job from a message."""
        return cls(**message["job"])


def encode(message: dict[str, Any]) -> str:
    """Encode a message as a line of its own, even if Blender has left a line unfinished."""
    return f"\n{MARK}{json.dumps(message)}\n"


def decode(line: str) -> dict[str, Any] | None:
    """Decode a line; None if it is not a message."""
    return json.loads(line[len(MARK) :]) if line.startswith(MARK) else None
