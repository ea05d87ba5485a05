"""Runs in a separate process, so that a crash of Blender becomes one line of error.

The command line starts itself again and waits. That costs the start of a second interpreter
without the large packages: a few hundredths of a second.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from types import FrameType

from ..batch.process import ending, environment
from .interrupts import interrupts_wait
from .status import INTERRUPTED

CHILD = "--child"
"""First argument of the process that does the work."""


SECONDS_TO_LEAVE = 0.8
"""Time that a process has to end after an interrupt before it is killed."""


class CrashError(Exception):
    """The process that did the work has crashed; the message says how."""


def run_apart(command: Sequence[str], expected: Sequence[int]) -> int:
    """Run a process to its end and return its exit status.

    An interrupt of this process interrupts the other one too. If that does not end soon, because a
    long computation keeps it busy, it is killed, and the status is `INTERRUPTED`.

    Parameters
    ----------
    command
        Starts the process. Its standard output is discarded; it shares this standard error.
        Interrupts are held back in it until it calls `leave_at_interrupt`.
    expected
        Exit statuses with which the process has reported its outcome itself.

    Raises
    ------
    CrashError
        The process ended in any other way.
    """
    is_interrupted = False

    def pass_on(number: int, frame: FrameType | None) -> None:
        nonlocal is_interrupted
        is_interrupted = True
        if os.name != "nt":  # a console of Windows interrupts all its processes by itself
            process.send_signal(number)
        killer = threading.Timer(SECONDS_TO_LEAVE, process.kill)
        killer.daemon = True
        killer.start()

    with interrupts_wait():
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,  # is closed when this process ends, see `follow_parent`
            stdout=subprocess.DEVNULL,
            env=environment(),
        )
        before = signal.signal(signal.SIGINT, pass_on)
    try:
        status = process.wait()
    finally:
        # Blender has a handler of its own, which Python cannot name; then the system's serves.
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)
        if process.stdin is not None:
            process.stdin.close()
    if is_interrupted and status not in expected:
        return INTERRUPTED
    if status not in expected:
        raise CrashError(ending(status))
    return status


def follow_parent() -> None:
    """End this process as soon as the process that started it has ended."""

    def wait() -> None:
        # Not sys.stdin: an interpreter that ends aborts if a thread still holds that one's lock.
        while os.read(0, 4096):
            pass
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def keep_to_own_messages() -> None:
    """Pass only this program's own messages to standard error, none of a C library."""
    own = os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    sys.stderr = os.fdopen(own, "w", buffering=1)


def prepare_standard_streams() -> None:
    """Open those of the three standard streams that the caller has closed; they lead nowhere."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free number, which is this one
    for name, number in (("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w", closefd=False))
