"""Worker process of a batch: does jobs from standard input until that is closed.

The process ends at once when its batch ends, whatever it is doing: outputs appear whole or not at
all.
"""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from pathlib import Path
from typing import Any

from ...batch.memory_use import peak_bytes, resident_bytes
from ...batch.messages import Job, decode, encode
from ...batch.schedule import START_BYTES
from ...core import DenoiseSettings, FairingError, PreparedMesh
from ...core.denoising.plan import STRENGTHS
from ...files.formats import keeps_axes
from ...files.report import settings_of_record, settings_record, strict
from ..data.mesh_arrays import MeshData
from .file_job import FairingJob, Preparation, run_job
from .frame_sequence import Place, Preparations, read_place, same_strength
from .solve import Settings

KEY_BYTES = 24
"""Bytes of a vertex in the list of results and in a shape key, for each step or strength."""

EXPORT_BYTES = 200
"""Bytes of a vertex while the output is written, with the copies that exporters make."""


REFINE_BYTES, REFINE_KEY_BYTES = 480, 56
"""Bytes of a vertex of a refined output while it is made, and those for each step or strength."""


class _PutAsideError(Exception):
    """There is not enough memory for this mesh at present."""


def serve() -> None:
    """Do jobs until the batch ends."""
    inbox = _Inbox()
    server = _Server(inbox)
    while (message := inbox.next_job()) is not None:
        _send(server.answer(Job.of(message)))


class _Inbox:
    """Messages from the batch, read in a thread so that the batch's end is noticed at any time."""

    def __init__(self) -> None:
        self._messages: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        self._is_idle = threading.Event()
        threading.Thread(target=self._read, daemon=True).start()

    def next_job(self) -> dict[str, Any] | None:
        """Wait for a job; None if the batch has ended."""
        self._is_idle.set()
        message = self._messages.get()
        self._is_idle.clear()
        return message

    def answer(self) -> dict[str, Any]:
        """Wait for the batch's answer in the middle of a job."""
        return self._messages.get()

    def _read(self) -> None:
        for line in sys.stdin:
            message = decode(line)
            if message is not None:
                self._messages.put(message)
        if not self._is_idle.is_set():
            os._exit(1)
        self._messages.put(None)


class _Server:
    """Does jobs, and keeps what the next one can use again."""

    def __init__(self, inbox: _Inbox) -> None:
        self._inbox = inbox
        self._preparations = Preparations()
        self._last: tuple[PreparedMesh, int] | None = None

    def answer(self, job: Job) -> dict[str, Any]:
        """Do a job and report its outcome."""
        started = time.perf_counter()
        try:
            account = self._measure(job) if job.output is None else self._fair(job)
        except _PutAsideError:
            return {"event": "later"}
        except (FairingError, OSError) as error:
            return {"event": "failed", "error": " ".join(str(error).split()), **self._memory()}
        except MemoryError:
            return {"event": "failed", "error": "not enough memory", **self._memory()}
        seconds = time.perf_counter() - started
        return {"event": "done", **account, "seconds": seconds, **self._memory()}

    def _fair(self, job: Job) -> dict[str, Any]:
        settings = settings_of_record(job.settings)
        source, output = Path(job.input), Path(job.output)
        self._preparations.turn_to(
            _place(job.reference),
            job.object_name,
            settings,
            scale=job.scale,
            keep_axes=keeps_axes(source, output),
        )
        task = FairingJob(
            source, output, settings, job.object_name, frame=job.frame, refine=job.refine
        )

        def prepare(data: MeshData) -> Preparation:
            return self._preparations.of(data, settings, job.scale)

        def admit(prepared: PreparedMesh) -> None:
            self._ask_for_memory(prepared, settings, job.refine)

        return {"report": run_job(task, prepare=prepare, admit=admit)}

    def _measure(self, job: Job) -> dict[str, Any]:
        data = read_place((Path(job.input), job.frame), job.object_name)
        settings, scale = same_strength(data, settings_of_record(job.settings))
        return {"settings": settings_record(settings), "scale": scale}

    def _ask_for_memory(
        self, prepared: PreparedMesh, settings: Settings, refine: int | None
    ) -> None:
        if self._last is None or self._last[0] is not prepared:
            is_denoise = isinstance(settings, DenoiseSettings)
            n_shapes = len(STRENGTHS) if is_denoise else settings.steps
            n_vertices = len(prepared.surface.vertex_of) * 4 ** (refine or 0)
            per_vertex = KEY_BYTES * n_shapes + EXPORT_BYTES
            if refine is not None:
                per_vertex += REFINE_BYTES + REFINE_KEY_BYTES * n_shapes
            needed = (
                (resident_bytes() or START_BYTES)
                + prepared.needed_bytes("denoise" if is_denoise else "fair")
                + per_vertex * n_vertices
            )
            # Reading the file may have taken more than the solve will.
            self._last = prepared, max(needed, peak_bytes() or 0)
        _send({"event": "needs", "bytes": self._last[1]})
        if self._inbox.answer()["answer"] != "go":
            raise _PutAsideError

    def _memory(self) -> dict[str, Any]:
        needed = self._last[1] if self._last is not None else None
        return {"needed_bytes": needed, "peak_bytes": peak_bytes()}


def _place(reference: tuple[str, int | None] | None) -> Place | None:
    return None if reference is None else (Path(reference[0]), reference[1])


def _send(message: dict[str, Any]) -> None:
    sys.stdout.write(encode(strict(message)))
    sys.stdout.flush()
