"""Worker process as its batch sees it: messages in and out, and how the process ended."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

from .memory_use import resident_bytes
from .messages import decode, encode

SECONDS_TO_LEAVE = 5.0

PACKAGE_FOLDER = Path(__file__).resolve().parents[2]
"""Folder that holds this package."""

Events = queue.SimpleQueue[tuple["WorkerProcess", dict[str, Any]]]


class WorkerProcess:
    """A process that fairs one mesh after the other.

    Parameters
    ----------
    command
        Command that starts the program as a worker.
    events
        Queue that receives its messages, each with the worker that sent it. The last one is
        ``{"event": "ended"}``, however the process ended.
    """

    def __init__(self, command: Sequence[str], events: Events) -> None:
        self._events = events
        self._errors: IO[bytes] = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            encoding="utf-8",
            errors="replace",
            env=environment(),
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests, self._answers = self._process.stdin, self._process.stdout
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def held_bytes(self) -> int:
        """Memory that the process holds now; 0 if the system does not say."""
        return resident_bytes(self._process.pid) or 0

    def send(self, message: dict[str, Any]) -> None:
        """Send a message. A dying process may lose it; its end is reported in any case."""
        try:
            self._requests.write(encode(message))
            self._requests.flush()
        except OSError:
            pass

    def end(self) -> None:
        """Ask the process to end now. An output that it is writing is left unfinished."""
        try:
            self._requests.close()  # which tells a worker to leave
        except OSError:
            pass
        try:
            self._process.wait(SECONDS_TO_LEAVE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join()
        self._close()

    def kill(self) -> None:
        """Kill the process at once, whatever it is doing."""
        self._process.kill()
        self.end()

    def how_it_ended(self) -> str:
        """Message that says how a process ended that was not told to end."""
        code = self._process.wait()
        self._errors.seek(0)
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        last = next((line.strip() for line in reversed(lines) if line.strip()), "")
        self._close()
        return f"the worker process was ended {ending(code)}" + (f": {last}" if last else "")

    def _read(self) -> None:
        for line in self._answers:
            message = decode(line)
            if message is not None:
                self._events.put((self, message))
        self._events.put((self, {"event": "ended"}))

    def _close(self) -> None:
        for stream in (self._requests, self._answers, self._errors):
            try:
                stream.close()
            except OSError:  # a request was still waiting, and the process has ended
                pass


def ending(status: int) -> str:
    """Describe the end of a process that reported no outcome, by its exit status."""
    if status >= 0:
        return f"with status {status}"
    known = {each.value: f" ({each.name})" for each in signal.Signals}
    return f"by signal {-status}{known.get(-status, '')}"


def environment() -> dict[str, str]:
    """Environment variables by which a child finds this package, wherever it is started."""
    given = os.environ.get("PYTHONPATH")
    path = os.pathsep.join([*([given] if given else []), str(PACKAGE_FOLDER)])
    return {**os.environ, "PYTHONPATH": path}
