"""Fair some two hundred meshes as a batch: failures, a kill, two workers, a limit of memory.

    python -m benchmarks.batch [--count 200] [--meshes FOLDER] [--memory 3G] [--work DIR]

The meshes are those of FOLDER, made ones of many sizes and valences, and some that cannot be
faired. They are faired by one worker and by two, in turns on shards of the meshes, so that what
else the machine does hits both; by two, killed when half is done and run again; and a quarter of
them by four under the limit. The outputs of all runs are compared byte by byte.
"""

from __future__ import annotations

import argparse
import filecmp
import json
import shutil
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import psutil

from adaptive_fairing.batch.plan import RECORDS
from adaptive_fairing.files.formats import SUFFIXES

from . import meshes as made
from .measuring import load, machine, table
from .program import run_program

SIZES = (200, 500, 1000, 2000, 5000, 10000, 20000)
"""Triangles of the made meshes."""

BROKEN = {
    "empty.ply": "",
    "no_mesh.ply": "this is no mesh\n",
    "cut_off.ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n",
    "no_numbers.obj": "v nan 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n",
    "points_only.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "no_surface.obj": "v 0 0 0\nv 1 0 0\nf 1 2 1\n",
    "no_gltf.glb": "glTF, but not really\n",
}
N_SHARDS = 4
EVERY_BROKEN = 20  # of so many meshes one is broken


@dataclass
class Run:
    """One run of the command line.

    Attributes
    ----------
    status
        Exit status, below 0 if it was killed.
    seconds, processor_seconds
        By the wall clock, and of all its processes, as far as they have ended by themselves.
    largest_bytes
        Most memory that the worker processes held together, sampled; pages that they share are
        counted in each.
    summary
        What it wrote.
    """

    status: int
    seconds: float
    processor_seconds: float
    largest_bytes: int
    summary: dict


def main() -> int:
    """Make the meshes, run the batches, print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200, help="meshes (default: %(default)s)")
    parser.add_argument("--meshes", type=Path, help="folder with more meshes")
    parser.add_argument("--memory", default="3G", help="limit (default: %(default)s)")
    parser.add_argument("--work", type=Path, help="where to work (default: a temporary folder)")
    options = parser.parse_args()
    print(f"{machine()}; {load()}\n")
    with tempfile.TemporaryDirectory() as temporary:
        work = options.work or Path(temporary)
        given = work / "given"
        collect(given, options.count, options.meshes)
        one, whole = in_turns(given, work / "one", work / "whole")
        print_failures(one)
        killed = run_batch(
            given, work / "two", "--jobs", "2", kill_at=one.summary["counts"]["done"] // 2
        )
        resumed = run_batch(given, work / "two", "--jobs", "2")
        limits = ["--memory", options.memory, "--shard", f"1/{N_SHARDS}"]
        limited = run_batch(given, work / "limited", "--jobs", "4", *limits)
        print_runs({
            "1 worker": one, "2 workers": whole, "2 workers, killed": killed,
            "2 workers, run again": resumed,
            f"4 workers, {options.memory}, a quarter": limited,
        })  # fmt: skip
        print(f"\n2 workers against 1: {one.seconds / whole.seconds:.2f} times as fast")
        print(f"memory limit {options.memory}: {limited.largest_bytes / 1e9:.2f} GB held at most")
        folders = [work / name for name in ("two", "whole", "limited")]
        differing = sum(len(differences(folder, work / "one")) for folder in folders)
        print(f"outputs that differ from those of one worker: {differing}")
    return 1 if differing else 0


def collect(folder: Path, count: int, more: Path | None) -> None:
    """Fill a folder with meshes; one that is there already is left as it is."""
    if folder.exists():
        return
    folder.mkdir(parents=True)
    if more is not None:
        for path in sorted(more.iterdir()):
            if path.suffix.lower() in SUFFIXES:
                shutil.copy(path, folder / path.name)
    for index in range(max(count // EVERY_BROKEN, 1)):
        name, text = list(BROKEN.items())[index % len(BROKEN)]
        (folder / f"broken_{index:02d}_{name}").write_text(text)
    for index in range(max(count - len(list(folder.iterdir())), 0)):
        size = SIZES[index % len(SIZES)]
        mesh = made.irregular(size) if index % 2 else made.sphere(size)
        # Other coordinates for each, so that no two outputs are the same.
        mesh = mesh._replace(vertices=mesh.vertices * (1 + 0.01 * index))
        mesh.write(folder / f"made_{index:03d}_{size}.ply")


def in_turns(given: Path, one: Path, two: Path) -> tuple[Run, Run]:
    """Run the batch with one worker and with two, shard by shard in turns."""
    totals = {
        folder: Run(0, 0.0, 0.0, 0, {"meshes": [], "counts": Counter()}) for folder in (one, two)
    }
    for shard in range(1, N_SHARDS + 1):
        turns = [(one, "1"), (two, "2")]
        for folder, jobs in turns if shard % 2 else turns[::-1]:
            run = run_batch(given, folder, "--jobs", jobs, "--shard", f"{shard}/{N_SHARDS}")
            total = totals[folder]
            total.status = max(total.status, run.status)
            total.seconds += run.seconds
            total.processor_seconds += run.processor_seconds
            total.largest_bytes = max(total.largest_bytes, run.largest_bytes)
            total.summary["meshes"] += run.summary["meshes"]
            total.summary["counts"].update(run.summary["counts"])
    return totals[one], totals[two]


def run_batch(given: Path, output: Path, *options: str, kill_at: int | None = None) -> Run:
    """Run the command line on all meshes; kill it when so many are done."""
    report = output.with_suffix(".json")
    report.unlink(missing_ok=True)
    largest = 0

    def look(process: psutil.Process) -> None:
        nonlocal largest
        largest = max(largest, sum(child.memory_info().rss for child in process.children()))
        if kill_at is not None and len(list(output.glob(f"{RECORDS}/*"))) >= kill_at:
            process.kill()

    run = run_program(
        "denoise", given, "--out-dir", output, "--report", report, *options, look=look
    )
    summary = json.loads(report.read_text()) if report.exists() else {}
    return Run(run.status, run.seconds, run.processor_seconds, largest, summary)


def print_failures(run: Run) -> None:
    """Print every reason to fail, and how many meshes had it."""
    failed = [mesh for mesh in run.summary["meshes"] if mesh["status"] == "failed"]
    reasons = Counter(map(reason_of, failed))
    print(table(("failed", "because"), [[str(n), text] for text, n in reasons.items()]))


def reason_of(mesh: dict) -> str:
    """Shorten an error message: without names of files and advice."""
    path = Path(mesh["input"])
    text = mesh["error"].split(";")[0].replace(str(path), "FILE")
    return text.replace(path.name, "FILE").replace(path.stem, "MESH")


def print_runs(runs: dict[str, Run]) -> None:
    """Print a row for each run."""
    rows = []
    for name, run in runs.items():
        counts = run.summary.get("counts", {})
        rows.append([
            name, *(str(counts.get(key, "")) for key in ("done", "skipped", "failed")),
            "killed" if run.status < 0 else str(run.status),
            f"{run.seconds:.1f}", f"{run.processor_seconds:.1f}", f"{run.largest_bytes / 1e6:.0f}",
        ])  # fmt: skip
    header = ("run", "done", "skipped", "failed", "exit", "s", "processor s", "held MB")
    print("\n" + table(header, rows))


def differences(folder: Path, reference: Path) -> list[str]:
    """Names of the outputs that are not the same, byte by byte, as those of a reference."""
    names = [path.name for path in folder.iterdir() if path.is_file()]
    _, other, missing = filecmp.cmpfiles(folder, reference, names, shallow=False)
    return other + missing


if __name__ == "__main__":
    sys.exit(main())
