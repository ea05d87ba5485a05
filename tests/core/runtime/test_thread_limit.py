"""A limit for the threads of the whole process."""

import threading

import pytest

from adaptive_fairing.core.runtime import threads
from adaptive_fairing.core.runtime.threads import limit_threads, n_threads, ordered_map


@pytest.fixture(autouse=True)
def _sixteen_processors(monkeypatch):
    monkeypatch.setattr(threads.os, "sched_getaffinity", lambda _: set(range(16)), raising=False)
    limit_threads(1)  # forgets what the machine has
    limit_threads(0)
    yield
    monkeypatch.undo()
    limit_threads(1)
    limit_threads(0)


@pytest.mark.parametrize(("limit", "expected"), [(0, 8), (1, 1), (3, 3), (12, 12), (99, 16)])
def test_it_holds_between_one_and_the_processors(limit, expected):
    limit_threads(limit)
    assert n_threads() == expected


def test_work_that_comes_later_keeps_to_it():
    def thread(_):
        return threading.current_thread()

    assert threading.current_thread() not in set(ordered_map(thread, range(4)))
    limit_threads(1)
    assert set(ordered_map(thread, range(4))) == {threading.current_thread()}
