"""Interrupts (Ctrl-C) while the program starts and while it works."""

from __future__ import annotations

import os
import signal
from types import FrameType

from .status import INTERRUPTED


def leave_at_interrupt() -> None:
    """Let an interrupt end the process at once and without a word, as long as it only starts."""
    signal.signal(signal.SIGINT, _leave)


def raise_at_interrupt() -> None:
    """From now on raise KeyboardInterrupt at the first interrupt; further ones change nothing."""
    if signal.getsignal(signal.SIGINT) is _leave:
        signal.signal(signal.SIGINT, _raise_once)


def ignore_interrupts() -> None:
    """From now on let interrupts change nothing: all is done and told."""
    if signal.getsignal(signal.SIGINT) in (_leave, _raise_once):
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _leave(number: int, frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)


def _raise_once(number: int, frame: FrameType | None) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    raise KeyboardInterrupt
