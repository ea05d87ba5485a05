"""Batches of the command line: run them, and look at what they have written. Needs bpy."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

from adaptive_fairing.batch.plan import RECORDS
from adaptive_fairing.cli import main as cli

from .warm_worker import worker_command

ROOT = Path(__file__).resolve().parents[2]


def batch(*arguments, algorithm="denoise"):
    """Run a batch, in a worker process that is there already unless --jobs asks for others.

    Returns its status.
    """
    given = [algorithm, *map(str, arguments)]
    starts_workers = any(argument.startswith("--jobs") for argument in given)
    return cli.main(given, worker_command=None if starts_workers else worker_command())


def command(*arguments, algorithm="denoise"):
    """Start the program in a process of its own, as a subprocess.Popen."""
    return subprocess.Popen(
        [sys.executable, "-m", "adaptive_fairing", algorithm, *map(str, arguments)],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=None if sys.platform == "win32" else _heed_interrupts,
    )


def _heed_interrupts():
    """Undo what a shell does to programs in the background, for a test to interrupt one."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def summary(path):
    """Status of every output in a summary."""
    return {mesh["output"]: mesh["status"] for mesh in json.loads(path.read_text())["meshes"]}


def outputs(folder):
    """All files below a folder but the records, as bytes by name."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and RECORDS not in path.parts
    }
