"""The rules of `ordered_map`: order, laziness, exceptions, nesting, context."""

import threading
from contextvars import ContextVar

import numpy as np
import pytest

from adaptive_fairing.core.runtime import threads
from adaptive_fairing.core.runtime.threads import Workspace, chunks, ordered_map


@pytest.fixture(autouse=True, params=[1, 3])
def n_threads(request, monkeypatch):
    """With one thread and with several, whatever the machine has."""
    monkeypatch.setattr(threads, "n_threads", lambda: request.param)
    threads._pool.cache_clear()
    yield request.param
    if request.param > 1 and threads._pool.cache_info().currsize:
        threads._pool().shutdown()
    threads._pool.cache_clear()


def test_results_come_in_the_order_of_the_items(n_threads):
    """With several threads, the first item ends after the second one."""
    second_has_ended = threading.Event()

    def square(item):
        if item == 0 and n_threads > 1:
            assert second_has_ended.wait(timeout=60)
        if item == 1:
            second_has_ended.set()
        return item**2

    assert list(ordered_map(square, range(50))) == [item**2 for item in range(50)]


@pytest.mark.parametrize("n_items", [0, 1])
def test_few_items_are_computed_by_the_caller(n_items):
    def thread(_):
        return threading.current_thread()

    assert list(ordered_map(thread, range(n_items))) == [threading.current_thread()] * n_items


def test_several_threads_work_at_once(n_threads):
    """Each item waits until as many are under way as there are threads."""
    barrier = threading.Barrier(n_threads)

    def thread(_):
        barrier.wait(timeout=60)
        return threading.current_thread().name

    assert len(set(ordered_map(thread, range(2 * n_threads)))) == n_threads


def test_nothing_is_computed_before_it_is_asked_for_and_then_little_ahead(n_threads):
    begun = []
    results = ordered_map(begun.append, range(1000))
    assert begun == []
    next(results)
    results.close()
    assert len(begun) <= 2 * n_threads


def test_the_first_exception_in_order_is_raised_and_the_rest_is_dropped(n_threads):
    done = []

    def fail(item):
        if item in (3, 4):
            raise ValueError(f"item {item}")
        done.append(item)
        return item

    results = ordered_map(fail, range(1000))
    assert [next(results) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(ValueError, match="item 3"):
        next(results)
    assert len(done) < 4 + 2 * n_threads
    # The threads are free for other work.
    assert list(ordered_map(str, range(4))) == ["0", "1", "2", "3"]


def test_a_thread_at_work_computes_a_nested_call_itself():
    """Two of three threads are at work: the third must not get any item."""

    def inner(item):
        return item, threading.current_thread()

    def outer(item):
        found = list(ordered_map(inner, range(item, item + 10)))
        assert {thread for _, thread in found} == {threading.current_thread()}
        return [number for number, _ in found]

    assert list(ordered_map(outer, range(2))) == [list(range(10)), list(range(1, 11))]


def test_threads_see_the_context_variables_of_the_caller():
    unit = ContextVar("unit", default=1)
    unit.set(7)
    assert list(ordered_map(lambda item: item * unit.get(), range(5))) == [0, 7, 14, 21, 28]


@pytest.mark.parametrize("n", [0, 1, 19, 20, 21, 40, 41, 1000])
def test_chunks_are_an_even_number_of_slices_of_at_most_their_size(n):
    """Together they are all numbers, each once; fewer than two full slices are left whole."""
    cut = chunks(n, 10)
    assert [number for part in cut for number in range(n)[part]] == list(range(n))
    if n < 20:
        assert len(cut) == 1
    else:
        lengths = [part.stop - part.start for part in cut]
        assert len(cut) % 2 == 0 and max(lengths) <= 10 and max(lengths) - min(lengths) <= 1


def test_every_thread_has_its_own_arrays():
    workspace = Workspace()
    mine = workspace.array("a", 3)
    theirs = []
    other = threading.Thread(target=lambda: theirs.append(workspace.array("a", 3)))
    other.start()
    other.join()
    mine[:] = 1
    theirs[0][:] = 2
    assert mine.tolist() == [1, 1, 1]
    assert workspace.array("a", 2).base is mine.base


def test_large_arrays_are_not_kept(monkeypatch):
    monkeypatch.setattr(threads, "LARGEST_KEPT", 80)
    workspace = Workspace()
    assert workspace.array("a", 2, 5).base is workspace.array("a", 10).base
    assert workspace.array("a", 11) is not workspace.array("a", 11)
    small = [workspace.array("b", 20, dtype=np.int32) for _ in range(2)]
    assert small[0].base is small[1].base
