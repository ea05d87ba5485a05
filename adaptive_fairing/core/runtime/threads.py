"""Threads around numpy and scipy calls that release the interpreter lock.

Work is cut into chunks: neighbouring triangles, vertices or matrix rows that one thread works on at
a time (`chunks`).  `ordered_map` is the only way to run them, and its rules are the only ones
(`for_each` is the same without results, `side_by_side` for different computations):

order       results come back in the order of the items, whatever thread was first: sums over them
            are the same to the last bit from run to run
exceptions  the first exception in this order is raised; items that no thread has begun are dropped
nesting     a thread at work computes the items of a nested call itself, so it never waits for
            threads that wait for it
context     a thread sees the context variables of the caller
"""

from __future__ import annotations

import math
import operator
import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

Item = TypeVar("Item")
Result = TypeVar("Result")
Number: TypeAlias = type[np.number[Any]]

MOST_THREADS = 8  # beyond that memory bandwidth is the limit

# Bytes of an array that a workspace keeps: larger ones would be missing elsewhere.
LARGEST_KEPT = 64_000_000


def limit_threads(limit: int) -> None:
    """Use at most this many threads from now on; 0 goes back to `MOST_THREADS`."""
    global _limit  # one number for the process, as are the threads
    if limit != _limit:
        _limit = limit
        n_threads.cache_clear()
        _pool.cache_clear()


_limit = 0


@lru_cache(maxsize=1)
def n_threads() -> int:
    """Processors that this process may use, at most `MOST_THREADS` or the limit that was set."""
    if hasattr(os, "sched_getaffinity"):
        available = len(os.sched_getaffinity(0))
    else:
        available = os.cpu_count() or 1
    return min(available, _limit or MOST_THREADS)


def chunks(n: int, size: int) -> list[slice]:
    """Cut n numbers into slices of at most `size`; one slice if there would be fewer than two.

    Handing over less work would take longer than doing it.  The number of slices is even, which
    suits an even number of threads.  It does not depend on the number of threads, and so neither do
    sums over the slices.
    """
    n_slices = 1 if n < 2 * size else 2 * -(-n // (2 * size))
    ends = [n * index // n_slices for index in range(n_slices + 1)]
    return [slice(*each) for each in pairwise(ends)]


def ordered_map(function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """Yield function(item) for all items in their order, computed by several threads.

    Nothing is computed before the first result is asked for; from then on at most two items per
    thread are under way or wait to be fetched.
    """
    if len(items) < 2 or n_threads() == 1 or getattr(_this_thread, "is_worker", False):
        yield from map(function, items)
        return
    pool = _pool()
    waiting: deque[Future[Result]] = deque()
    try:
        for item in items:
            waiting.append(pool.submit(copy_context().run, function, item))
            if len(waiting) >= 2 * n_threads():
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        for future in waiting:
            future.cancel()


def for_each(function: Callable[[Item], None], items: Sequence[Item]) -> None:
    """Run function(item) for all items by several threads, by the rules of `ordered_map`."""
    for _ in ordered_map(function, items):
        pass


def side_by_side(*functions: Callable[[], Any]) -> list[Any]:
    """Call functions by several threads, by the rules of `ordered_map`; return their results."""
    return list(ordered_map(operator.call, functions))


_this_thread = threading.local()


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    def mark_as_worker() -> None:
        _this_thread.is_worker = True

    return ThreadPoolExecutor(n_threads(), "adaptive_fairing", mark_as_worker)


class Workspace(threading.local):
    """Arrays that each thread uses again: fresh memory costs more than filling it."""

    def __init__(self) -> None:
        self._buffers: dict[tuple[str, Number], NDArray[Any]] = {}

    def array(self, name: str, *shape: int, dtype: Number = np.float64) -> NDArray[Any]:
        """Return an uninitialised array, valid until this thread asks for `name` again."""
        size = math.prod(shape)
        if size * np.dtype(dtype).itemsize > LARGEST_KEPT:
            return np.empty(shape, dtype)
        key = name, dtype
        buffer = self._buffers.get(key)
        if buffer is None or len(buffer) < size:
            buffer = self._buffers[key] = np.empty(size, dtype)
        return buffer[:size].reshape(shape)
