"""Worker processes and memory: with workers that do as they are told, and without Blender."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from adaptive_fairing.batch.messages import Job, decode, encode
from adaptive_fairing.batch.plan import Item
from adaptive_fairing.batch.schedule import START_BYTES, Schedule, Task, first_claim

ROOT = Path(__file__).resolve().parents[2]
COMMAND = [sys.executable, str(Path(__file__).with_name("fake_worker.py"))]
GIGABYTE = 10**9


@pytest.fixture
def log(tmp_path, monkeypatch):
    path = tmp_path / "log"
    path.touch()
    monkeypatch.setenv("FAKE_LOG", str(path))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    return lambda: [json.loads(line) for line in path.read_text().splitlines()]


def task(name, wishes, claim=0):
    item = Item(name, Path(name), None, None, Path(name), Path(name))
    return Task(item, Job(name, None, wishes, {}, name), claim)


def run(tasks, jobs=2, limit=None):
    return {each.item.name: each for each in Schedule(COMMAND, jobs, limit).run(tasks)}


def most_at_a_time(entries, amount):
    """Largest sum of `amount` over what was at work at the same time."""
    now = most = 0
    for entry in entries:
        if entry["what"] in ("start", "end"):
            now += amount(entry) * (1 if entry["what"] == "start" else -1)
            most = max(most, now)
    return most


def test_every_mesh_is_done_once(log):
    names = [f"mesh {i}" for i in range(12)]
    outcomes = run([task(name, "takes=0.01") for name in names])
    assert sorted(outcomes) == sorted(names)
    assert all(outcome.error is None for outcome in outcomes.values())
    assert outcomes["mesh 3"].account == {"report": {"of": "mesh 3"}}
    started = [entry["output"] for entry in log() if entry["what"] == "start"]
    assert sorted(started) == sorted(names)


@pytest.mark.parametrize("jobs", [1, 2, 3])
def test_so_many_work_at_a_time_as_there_are_jobs(log, jobs):
    run([task(f"mesh {i}", "takes=0.5") for i in range(3 * jobs)], jobs=jobs)
    assert most_at_a_time(log(), lambda entry: 1) == jobs
    assert len({entry["process"] for entry in log()}) == jobs


def test_a_failure_is_told_and_the_rest_goes_on(log):
    wishes = ["", "fails=no good", "dies=9", "dies=11", "", "fails=worse", ""]
    outcomes = run([task(f"mesh {i}", wish) for i, wish in enumerate(wishes)])
    errors = [outcomes[f"mesh {i}"].error for i in range(len(wishes))]
    assert [error is None for error in errors] == [not wish for wish in wishes]
    assert errors[1] == "no good"
    assert errors[2] == "the worker process was ended by signal 9 (SIGKILL): something terrible"
    assert errors[3] == "the worker process was ended by signal 11 (SIGSEGV): something terrible"


def test_a_command_that_does_not_start_a_worker_fails_every_mesh():
    command = [sys.executable, "-c", "import sys; sys.exit('no Blender here')"]
    tasks = [task(f"mesh {i}", "") for i in range(3)]
    outcomes = list(Schedule(command, 2, None).run(tasks))
    assert {outcome.error for outcome in outcomes} == {
        "the worker process was ended with status 1: no Blender here"
    }
    assert len(outcomes) == 3


@pytest.mark.parametrize("seed", range(4))
def test_the_limit_holds_and_everything_gets_its_turn(log, seed):
    """What is at work never needs more than the limit, however it was guessed at first."""
    rng = np.random.default_rng(seed)
    needs = rng.uniform(0.2, 3.0, 16).round(2)
    tasks = [task(f"mesh {i}", f"needs={n},takes=0.02", 10**8) for i, n in enumerate(needs)]
    outcomes = run(tasks, jobs=4, limit=3 * GIGABYTE)
    assert all(outcome.error is None for outcome in outcomes.values())
    assert len(outcomes) == len(needs)
    most = most_at_a_time(log(), lambda entry: float(entry["needs"]))
    assert most <= 3.0
    assert any(entry["what"] == "aside" for entry in log()), "nothing had to wait: no test"


def test_a_mesh_beyond_the_limit_is_refused_with_the_numbers(log):
    outcomes = run(
        [task("small", "needs=0.5"), task("large", "needs=5"), task("huge", "", 9 * GIGABYTE)],
        limit=2 * GIGABYTE,
    )
    assert outcomes["small"].error is None
    assert outcomes["large"].error.startswith(
        "needs about 5.00 GB of memory, the limit is 2.00 GB: raise --memory"
    )
    assert outcomes["huge"].error.startswith("needs about 9.00 GB")
    assert [entry["output"] for entry in log() if entry["what"] == "start"] == ["small"]


def test_a_process_that_held_much_ends_and_gives_it_back(log):
    tasks = [task("a", "needs=2"), task("b", "needs=0.5"), task("c", "needs=0.5")]
    run(tasks, jobs=1, limit=3 * GIGABYTE)
    process = {e["output"]: e["process"] for e in log() if e["what"] == "start"}
    assert process["a"] != process["b"] == process["c"]


def test_two_large_meshes_come_one_after_the_other(log):
    run([task(name, "needs=2,takes=0.2", 10**8) for name in "ab"], limit=3 * GIGABYTE)
    kinds = [entry["what"] for entry in log() if entry["what"] in ("start", "end")]
    assert kinds == ["start", "end", "start", "end"]


needs_proc = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="no /proc")


@needs_proc
def test_a_process_that_holds_more_than_the_limit_is_ended_and_replaced(log):
    tasks = [task("greedy", "holds=0.5,takes=600", 10**8), *(task(name, "") for name in "abc")]
    outcomes = run(tasks, jobs=1, limit=3 * 10**8)
    assert outcomes["greedy"].error.startswith("was stopped when it held 0.")
    assert "the limit is 0.30 GB: raise --memory" in outcomes["greedy"].error
    assert all(outcomes[name].error is None for name in "abc")
    process = {e["output"]: e["process"] for e in log() if e["what"] == "start"}
    assert process["greedy"] != process["a"] == process["c"]


@needs_proc
def test_meshes_that_hold_too_much_together_get_a_chance_alone(log):
    tasks = [task(name, "holds=0.25,takes=1.5", 10**8) for name in "ab"]
    outcomes = run(tasks, jobs=2, limit=4 * 10**8)
    assert [outcomes[name].error for name in "ab"] == [None, None]
    kinds = [entry["what"] for entry in log() if entry["what"] in ("start", "end")]
    assert kinds == ["start", "start", "end", "start", "end"]


def test_a_process_that_has_held_more_than_the_limit_is_not_used_again(log):
    """Even if it was too quick to be seen at it."""
    tasks = [task("a", "holds=0.4", 10**8), task("b", "", 10**8)]
    run(tasks, jobs=1, limit=3 * 10**8)
    process = {e["output"]: e["process"] for e in log() if e["what"] == "start"}
    assert process["a"] != process["b"]


def test_ending_the_generator_ends_the_processes(log):
    outcomes = Schedule(COMMAND, 2, None).run(
        [task("short", ""), *(task(f"long {i}", "takes=60") for i in range(3))]
    )
    next(outcomes)
    processes = {entry["process"] for entry in log()}
    outcomes.close()
    assert processes
    for process in processes:
        with pytest.raises(ProcessLookupError):
            os.kill(process, 0)


def test_the_first_guess_counts_the_file(tmp_path):
    path = tmp_path / "mesh.ply"
    path.write_bytes(bytes(1000))
    item = Item("m", path, None, None, path, path)
    assert first_claim(item) == START_BYTES + 4000
    path.unlink()
    assert first_claim(item) == START_BYTES


def test_messages_survive_what_blender_prints():
    message = {"event": "done", "text": "line\nline τ"}
    printed = f"Info: no newline at the end{encode(message)}more\n"
    assert [decode(line) for line in printed.splitlines() if decode(line)] == [message]


def test_scheduling_needs_neither_numpy_nor_blender():
    code = (
        "import sys\n"
        "sys.modules['bpy'] = sys.modules['numpy'] = sys.modules['scipy'] = None\n"
        "import adaptive_fairing.batch.schedule, adaptive_fairing.cli.batch"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
