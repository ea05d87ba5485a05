"""Interrupts (Ctrl-C) while the program starts and while it works."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator
from types import FrameType

from .status import INTERRUPTED


def leave_at_interrupt() -> None:
    """Let an interrupt end the process at once and silently, while the program is starting.

    An interrupt that `interrupts_wait` has held back arrives now.
    """
    signal.signal(signal.SIGINT, _leave)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


@contextlib.contextmanager
def interrupts_wait() -> Iterator[None]:
    """Hold interrupts back in the block; in a process started there, until `leave_at_interrupt`.

    A starting interpreter has no handler yet and would answer an interrupt with a traceback.
    Windows cannot hold interrupts back.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def raise_at_interrupt() -> None:
    """From now on raise KeyboardInterrupt at the first interrupt, and ignore further ones."""
    if signal.getsignal(signal.SIGINT) is _leave:
        signal.signal(signal.SIGINT, _raise_once)


def ignore_interrupts() -> None:
    """Ignore interrupts from now on: the work is done and reported."""
    if signal.getsignal(signal.SIGINT) in (_leave, _raise_once):
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _leave(number: int, frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)


def _raise_once(number: int, frame: FrameType | None) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    raise KeyboardInterrupt
