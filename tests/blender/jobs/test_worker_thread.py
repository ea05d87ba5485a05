"""The thread that computes beside the window, and the run that it works through."""

import threading

import numpy as np
import pytest
from support.meshes import icosphere

from adaptive_fairing.blender.jobs.solve import Solve, run_solves
from adaptive_fairing.blender.jobs.worker_thread import Worker
from adaptive_fairing.core import FairingError, FairingSettings, fair


def drain(worker):
    """Poll until the last item has come."""
    items = []
    while True:
        news, is_last = worker.poll()
        items += news
        if is_last:
            return items
        worker.join(0.01)


def test_all_items_arrive_in_order():
    assert drain(Worker(iter(range(100)))) == list(range(100))


def test_the_items_are_made_in_another_thread():
    def names():
        yield threading.current_thread()

    assert drain(Worker(names())) != [threading.current_thread()]


def test_a_stop_keeps_the_item_that_is_being_made_and_makes_no_other():
    is_made, may_go_on = threading.Event(), threading.Event()

    def items():
        yield 0
        is_made.set()
        may_go_on.wait()
        yield 1
        yield 2

    worker = Worker(items())
    is_made.wait()
    worker.stop()
    assert worker.is_stopping
    may_go_on.set()
    assert drain(worker) == [0, 1]


def test_an_error_comes_out_in_the_callers_thread():
    def items():
        yield 0
        raise ZeroDivisionError("here")

    with pytest.raises(ZeroDivisionError, match="here"):
        drain(Worker(items()))


class TestRun:
    def solve(self, levels=1, **settings):
        vertices, faces = icosphere(levels)
        return Solve(vertices, faces, FairingSettings(**settings), name="Ball")

    def test_steps_are_the_cores_as_float32(self):
        solve = self.solve(steps=3)
        assert [each is solve for each in run_solves([solve])] == [True] * 3
        expected = fair(solve.vertices, solve.triangles, solve.settings).steps
        for step, other in zip(solve.steps, expected, strict=True):
            assert step.positions.dtype == np.float32
            assert np.array_equal(step.positions, other.positions.astype(np.float32))
        assert solve.error is None
        assert solve.seconds > 0

    def test_a_bad_mesh_says_why_and_the_next_one_is_faired(self):
        bad, good = self.solve(), self.solve(steps=2)
        bad.vertices = bad.vertices * np.nan
        assert list(run_solves([bad, good])) == [good, good]
        assert "not finite" in bad.error
        assert bad.steps == []

    def test_a_solve_that_is_refused_already_is_left_out(self):
        solve = self.solve()
        solve.failure = FairingError("no")
        assert list(run_solves([solve])) == []

    def test_a_step_that_did_not_converge_is_not_kept(self):
        solve = self.solve(steps=3, cg_max_iterations=1, cg_tolerance=1e-12)
        assert list(run_solves([solve])) == []
        assert solve.error.startswith("step 1 did not converge: residual")

    def test_too_little_memory_is_said(self, monkeypatch):
        def exhausted(*arguments, **options):
            raise MemoryError

        monkeypatch.setattr("adaptive_fairing.blender.jobs.solve.fair_steps", exhausted)
        solve = self.solve()
        list(run_solves([solve]))
        assert solve.error.startswith("not enough memory for 80 triangles")
