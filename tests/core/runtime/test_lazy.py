"""Attributes that are computed once, also while others compute theirs."""

import threading

from adaptive_fairing.core.runtime.lazy import cached_property
from adaptive_fairing.core.runtime.threads import n_threads, ordered_map


class Counted:
    def __init__(self, before=lambda: None):
        self.before, self.n_computed = before, 0

    @cached_property
    def total(self):
        """The sum of some numbers, added up by several threads."""
        self.before()
        self.n_computed += 1
        return sum(ordered_map(int, range(10)))


def test_a_value_is_computed_once():
    counted = Counted()
    assert counted.n_computed == 0
    assert [counted.total, counted.total] == [45, 45]
    assert counted.n_computed == 1
    assert Counted.total.__doc__.startswith("The sum")


def test_two_callers_do_not_wait_for_each_other():
    """One computes a value by all threads, while these compute the same of other instances."""
    all_at_work = threading.Barrier(n_threads() + 1)

    def wait(_=None):
        all_at_work.wait(30)

    def totals_by_all_threads():
        def total(_):
            wait()
            return Counted().total

        totals.extend(ordered_map(total, range(n_threads())))

    totals = []
    callers = [
        threading.Thread(target=lambda: totals.append(Counted(wait).total), daemon=True),
        threading.Thread(target=totals_by_all_threads, daemon=True),
    ]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(60)
    assert totals == [45] * (n_threads() + 1)
