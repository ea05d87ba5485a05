"""Run every mesh file of a folder through the command line and print what became of it.

    python -m benchmarks.corpus FOLDER [-- OPTIONS OF adaptive-fairing denoise]

One process per mesh. The files that come out are read by meshio, not by Blender, and are compared
with the files that went in. Exit status 1 if anything looks wrong: a traceback, a message
of several lines, numbers that are not finite, other faces than those of the input.
"""

from __future__ import annotations

import argparse
import io
import json
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from .measuring import table
from .program import PREFIX, problems_of_run, run_program

COLUMNS = ("file", "outcome", "s", "MB", "vertices", "faces", "moved", "check", "messages")
READ = {".obj", ".ply"}


@dataclass
class RawMesh:
    """Vertices (n, 3) and polygons as tuples of vertex indices, as they stand in the file."""

    vertices: np.ndarray
    faces: list[tuple[int, ...]]


def read_mesh_file(path: Path) -> RawMesh:
    """Read positions and polygons of a file."""
    if path.suffix.lower() == ".obj":
        # Without normals and texture: meshio wants one of each for every vertex.
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
        kept = "\n".join(line for line in lines if line.startswith(("v ", "f ")))
        mesh = meshio.read(io.StringIO(kept), file_format="obj")
    else:
        mesh = meshio.read(path)
    rows = [row for cells in mesh.cells for row in cells.data.tolist() if len(row) > 2]
    return RawMesh(mesh.points, [tuple(row) for row in rows])


def main() -> int:
    """Run the folder and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("arguments", nargs="*", help="for adaptive-fairing denoise, after --")
    options = parser.parse_args()
    files = sorted(path for path in options.folder.iterdir() if path.suffix.lower() in READ)
    rows, n_suspicious = [], 0
    for file in files:
        row, is_suspicious = examine(file, options.arguments)
        n_suspicious += is_suspicious
        rows.append(row)
        print(f"{len(rows)}/{len(files)} {file.name}: {row[1]}", file=sys.stderr)
    print(table(COLUMNS, rows))
    print(f"\n{len(files)} files, {n_suspicious} suspicious")
    return 1 if n_suspicious else 0


def examine(file: Path, arguments: list[str]) -> tuple[list[str], bool]:
    """Run one file; give its row of the table, and whether something looks wrong."""
    with tempfile.TemporaryDirectory() as folder:
        output, report = Path(folder) / f"out{file.suffix}", Path(folder) / "report.json"
        run = run_program("denoise", file, "-o", output, "--report", report, *arguments)
        texts = [line.removeprefix(PREFIX) for line in run.messages]
        problems = problems_of_run(run)
        counts = ["", "", ""]
        if run.status == 0:
            json.loads(report.read_text(encoding="utf-8"), parse_constant=_no_constant)
            given, result = read_mesh_file(file), read_mesh_file(output)
            told = any("Blender leaves out" in text for text in texts)
            problems += differences(given, result, told=told)
            counts = [str(len(given.vertices)), str(len(given.faces)), moved(given, result)]
        elif output.exists():
            problems.append("output in spite of an error")
    outcome = {0: "faired", 1: "refused"}.get(run.status, f"status {run.status}")
    check = ", ".join(problems) or "ok"
    texts = [text for text in texts if "; wrote " not in text]
    numbers = [f"{run.seconds:.1f}", f"{run.megabytes:.0f}"]
    return [file.name, outcome, *numbers, *counts, check, "; ".join(texts)], bool(problems)


def differences(given: RawMesh, result: RawMesh, *, told: bool) -> list[str]:
    """Compare the files that went in and came out; losses are no problem if they were told."""
    problems = []
    if not np.isfinite(result.vertices).all():
        problems.append("not finite")
    if len(given.vertices) != len(result.vertices):
        if told:  # the others have new numbers: faces cannot be compared
            return problems
        problems.append(f"{len(result.vertices)} vertices came out")
    lost = Counter(map(cycle, given.faces)) - Counter(map(cycle, result.faces))
    added = Counter(map(cycle, result.faces)) - Counter(map(cycle, given.faces))
    if added:
        problems.append(f"{added.total()} faces added")
    if lost and not told:
        problems.append(f"{lost.total()} faces lost")
    return problems


def cycle(face: tuple[int, ...]) -> tuple[int, ...]:
    """Start a face at its lowest vertex: importers may begin elsewhere, not turn it round."""
    first = face.index(min(face))
    return face[first:] + face[:first]


def moved(given: RawMesh, result: RawMesh) -> str:
    """Count the vertices that moved, and measure the largest way against the mesh's box."""
    if given.vertices.shape != result.vertices.shape:
        return f"{len(result.vertices)} left"
    before, after = given.vertices.astype(np.float32), result.vertices.astype(np.float32)
    distance = np.linalg.norm(after - before, axis=1)
    size = max(float(np.ptp(before, axis=0).max()), 1e-30)
    return f"{np.count_nonzero(distance)} ({100 * distance.max() / size:.1f} %)"


def _no_constant(name: str) -> float:
    raise ValueError(f"the report holds {name}, which is not JSON")


if __name__ == "__main__":
    sys.exit(main())
