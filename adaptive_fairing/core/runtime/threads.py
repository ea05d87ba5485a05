"""Threads around numpy and scipy calls that release the interpreter lock.

Results come back in the order of the items, whatever thread was first, so that sums over them are
the same to the last bit from run to run.
"""

from __future__ import annotations

import math
import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .precision import Precision

Item = TypeVar("Item")
Result = TypeVar("Result")

MOST_THREADS = 8  # beyond that memory bandwidth is the limit

# Numbers of an array that a workspace keeps (64 MB): larger ones would be missing elsewhere.
LARGEST_KEPT = 8_000_000


@lru_cache(maxsize=1)
def n_threads() -> int:
    """Processors that this process may use, at most `MOST_THREADS`."""
    if hasattr(os, "sched_getaffinity"):
        available = len(os.sched_getaffinity(0))
    else:
        available = os.cpu_count() or 1
    return min(available, MOST_THREADS)


def ordered_map(function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """Yield function(item) for all items in their order, computed by several threads.

    At most two items per thread are under way or waiting to be fetched.
    """
    if len(items) < 2 or n_threads() == 1:
        yield from map(function, items)
        return
    pool = _pool()
    waiting: deque[Future[Result]] = deque()
    for item in items:
        waiting.append(pool.submit(function, item))
        if len(waiting) >= 2 * n_threads():
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(n_threads(), thread_name_prefix="adaptive_fairing")


class Workspace(threading.local):
    """Arrays that every thread uses again and again: fresh memory costs more than filling it."""

    def __init__(self) -> None:
        self._buffers: dict[tuple[str, Precision], NDArray[Any]] = {}

    def array(self, name: str, *shape: int, precision: Precision = np.float64) -> NDArray[Any]:
        """Return an array of any content, valid until this thread asks for `name` again."""
        size = math.prod(shape)
        if size > LARGEST_KEPT:
            return np.empty(shape, precision)
        key = name, precision
        buffer = self._buffers.get(key)
        if buffer is None or len(buffer) < size:
            buffer = self._buffers[key] = np.empty(size, precision)
        return buffer[:size].reshape(shape)
