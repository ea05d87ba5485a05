"""Attributes that are computed once, when they are first asked for."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any, TypeVar

Value = TypeVar("Value")


class cached_property(functools.cached_property[Value]):  # noqa: N801
    """As in `functools`, without the lock that it has up to Python 3.11.

    That lock is one for all instances.  A thread that holds it may wait for the threads of
    `ordered_map`, while these wait for the lock on behalf of another caller.  Without it two
    threads may both compute a value, which is the same.
    """

    def __init__(self, function: Callable[[Any], Value]) -> None:
        super().__init__(function)
        self.lock = nullcontext()
