"""Processes that die, are interrupted, or have lost their terminal: one line, or none."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.meshes import icosphere
from support.raw_files import write_raw

from adaptive_fairing.cli.apart import CrashError, run_apart

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and pipes of POSIX")

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = [sys.executable, "-m", "adaptive_fairing"]

DIES_AT = """
import os, signal, sys
def watch(event, arguments):
    if event == "open" and str(arguments[0]).endswith({name!r}) and "--child" in sys.orig_argv:
        os.kill(os.getpid(), signal.{signal})
sys.addaudithook(watch)
"""


@pytest.mark.parametrize(
    ("code", "how"),
    [
        ("import os; os.kill(os.getpid(), 11)", r"by signal 11 \(SIGSEGV\)"),
        ("import os; os.abort()", r"by signal 6 \(SIGABRT\)"),
        ("import os; os._exit(77)", "with status 77"),
    ],
)
def test_how_a_process_has_died_is_told(code, how):
    with pytest.raises(CrashError, match=how):
        run_apart([sys.executable, "-c", code], (0, 1))


@pytest.mark.parametrize("status", [0, 1])
def test_a_process_that_has_told_itself_is_believed(status):
    assert run_apart([sys.executable, "-c", f"import os; os._exit({status})"], (0, 1)) == status


@pytest.mark.parametrize("name", ["SIGSEGV", "SIGABRT", "SIGKILL"])
def test_a_crash_while_a_file_is_read_is_one_line(tmp_path, name):
    given, out = write_raw(tmp_path, "obj", *icosphere(1)), tmp_path / "out.ply"
    out.write_text("old")
    (tmp_path / "sitecustomize.py").write_text(DIES_AT.format(name=given.name, signal=name))
    result = subprocess.run(
        [*PROGRAM, "denoise", given, "-o", out],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (result.returncode, result.stdout) == (1, "")
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith(
        f"adaptive-fairing: error: Blender or the solver crashed on {given}"
    )
    assert name in result.stderr
    assert out.read_text() == "old"


STUBBORN = """
import os, signal, sys
from adaptive_fairing.cli.apart import run_apart
deaf = "import signal, time; signal.signal(2, signal.SIG_IGN); print(); time.sleep(1e6)"
deaf = deaf.replace("print()", "open(%r, 'w').close()" % sys.argv[1])
sys.exit(run_apart([sys.executable, "-c", deaf], (0, 1)))
"""


def test_a_process_in_the_middle_of_a_computation_is_killed_at_an_interrupt(tmp_path):
    """It would never end by itself; and it is told as an interrupt, not as a crash."""
    ready = tmp_path / "ready"
    process = subprocess.Popen([sys.executable, "-c", STUBBORN, ready], cwd=ROOT)
    while not ready.exists():
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    assert process.wait() == 130


READY = """
import sys
from adaptive_fairing.cli.interrupts import leave_at_interrupt
leave_at_interrupt()
print("ready", flush=True)
from adaptive_fairing.__main__ import run
run()
"""


@pytest.mark.parametrize("seed", range(5))
def test_an_interrupt_at_any_time_is_status_130_and_at_most_one_line(tmp_path, seed):
    given, out = write_raw(tmp_path, "obj", *icosphere(5)), tmp_path / "out.ply"
    options = ["--steps", "1000"]  # long enough
    process = subprocess.Popen(
        [sys.executable, "-c", READY, "fair", given, "-o", out, *options],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout.readline() == "ready\n"
    time.sleep(random.Random(seed).uniform(0, 3))
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all processes
    _, err = process.communicate()
    assert process.returncode == 130
    assert err in ("", "adaptive-fairing: error: interrupted: no output was written\n")
    assert list(tmp_path.iterdir()) == [given], "and no drafts"


SLOW_TO_START = """
import sys, time
if "--child" in sys.orig_argv:
    open({ready!r}, "w").close()
    time.sleep(0.5)
"""


def test_an_interrupt_while_the_second_interpreter_starts_is_at_most_one_line(tmp_path):
    given, ready = write_raw(tmp_path, "obj", *icosphere(1)), tmp_path / "ready"
    (tmp_path / "sitecustomize.py").write_text(SLOW_TO_START.format(ready=str(ready)))
    process = subprocess.Popen(
        [*PROGRAM, "fair", given, "-o", tmp_path / "out.ply"],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while not ready.exists():
        assert process.poll() is None
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 130
    assert err in ("", "adaptive-fairing: error: interrupted: no output was written\n")


@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (1, 2), (0, 1, 2)])
def test_standard_streams_may_be_closed(tmp_path, closed):
    given, out = write_raw(tmp_path, "obj", *icosphere(1)), tmp_path / "out.ply"

    def close():
        for number in closed:
            os.close(number)

    for source, status in ((given, 0), (tmp_path / "no.obj", 1)):
        result = subprocess.run(
            [*PROGRAM, "denoise", source, "-o", out],
            cwd=ROOT,
            preexec_fn=close,
            capture_output=True,
            text=True,
            check=False,
        )
        assert (result.returncode, result.stdout) == (status, "")
        assert result.stderr.count("adaptive-fairing: error: ") == (
            status if 2 not in closed else 0
        )
        assert "Traceback" not in result.stderr
    assert out.exists()


def test_nobody_needs_to_listen(tmp_path):
    given, out = write_raw(tmp_path, "obj", *icosphere(1)), tmp_path / "out.ply"
    reader, writer = os.pipe()
    os.close(reader)
    result = subprocess.run(
        [*PROGRAM, "denoise", given, "-o", out], cwd=ROOT, stderr=writer, check=False
    )
    os.close(writer)
    assert result.returncode == 0
    assert out.exists()


@pytest.mark.parametrize("megabytes", [300, 700, 1500])
@pytest.mark.parametrize("many", [False, True], ids=["single", "batch"])
def test_a_limit_of_the_address_space_is_told_in_one_line(tmp_path, megabytes, many):
    """Or does no harm: what is too little depends on the machine."""
    resource = pytest.importorskip("resource")
    given, out = write_raw(tmp_path, "obj", *icosphere(1)), tmp_path / "out"
    out.mkdir()
    result = subprocess.run(
        [
            *PROGRAM,
            "denoise",
            given,
            *(["--out-dir", out] if many else ["-o", out / "given.obj"]),
            "--quiet",
        ],
        cwd=ROOT,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (megabytes << 20,) * 2),
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode in (0, 1)
    failures = 1 + many if result.returncode else 0  # of a batch each mesh, and the whole
    assert 0 <= result.stderr.count("\n") <= failures
    assert (out / "given.obj").exists() == (result.returncode == 0)


@pytest.mark.parametrize("option", ["--steps", "--density-passes"])
@pytest.mark.parametrize("number", ["1e20", str(10**20)])
def test_numbers_of_steps_beyond_reason_are_refused(tmp_path, option, number):
    given = write_raw(tmp_path, "obj", *icosphere(1))
    result = subprocess.run(
        [*PROGRAM, "fair", given, option, number],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 2
    assert result.stderr.count("\n") == 1
    assert number in result.stderr
