"""Measure the flicker of a faired sequence: one strength for all frames, or each its own.

    python -m research.flicker [--frames 50]

A noisy foot bends to and fro; the noise moves along with the surface, so that what a steady
smoother removes hardly changes from one frame to the next. The frames go through the command line
as numbered files. Measured is the removed displacement, along the normals of the clean surface and
in local edge lengths: its change from frame to frame, relative to what is removed.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from benchmarks.measuring import load, machine, table
from benchmarks.program import ROOT, run_program
from tools.geometry.ply import read_ply, write_ply
from tools.geometry.triangles import Faces, FloatArray, local_edge_lengths, vertex_normals

NOISE = 0.15  # standard deviation in local edge lengths
BEND = 1.0  # of one end against the other, in radians
SEED = 20260009

CASES = {
    "fixed τ, mean edge": ["--tau", "0.004"],
    "until 60 % of the curvature is left": [
        "--tau", "0.001", "--steps", "12", "--stop-curvature", "0.6",
    ],
}  # fmt: skip
WAYS = {"each its own": [], "same strength": ["--same-strength"]}


@dataclass(frozen=True)
class Sequence:
    """Noisy frames of a surface.

    Attributes
    ----------
    frames
        (f, n, 3) positions.
    normals
        (f, n, 3) of the clean surface.
    edges
        (n,) local edge length of the clean surface.
    triangles
        (m, 3).
    """

    frames: FloatArray
    normals: FloatArray
    edges: FloatArray
    triangles: Faces

    def removed(self, faired: FloatArray) -> FloatArray:
        """Measure what was removed at every vertex in every frame, (f, n), in local edges."""
        moved = np.einsum("fnd,fnd->fn", faired - self.frames, self.normals)
        return moved / self.edges


def main() -> int:
    """Make the frames, fair them in every way and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=50)
    options = parser.parse_args()
    print(f"{machine()}; {load()}\n")
    sequence = bending(*read_ply(ROOT / "assets" / "foot.ply"), options.frames)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        given = Path(folder) / "given"
        write_frames(sequence, given)
        for case, arguments in CASES.items():
            for way, more in WAYS.items():
                output = Path(folder) / f"{case}, {way}"
                steps = fair_frames(given, output, [*arguments, *more])
                removed = sequence.removed(read_frames(output, options.frames))
                rows.append([case, way, *figures(removed, steps)])
                print(" | ".join(rows[-1]), file=sys.stderr)
    header = ("strength", "", "steps", "removed", "its jump", "change", "largest")
    print(table(header, rows))
    print(
        "\nremoved: RMS in local edges, over all frames; its jump: largest change of the RMS from "
        "one frame to the\nnext; change, largest: RMS difference of the removed displacement "
        "between two frames, mean and largest;\nthe last three relative to what is removed"
    )
    return 0


def bending(rest: FloatArray, triangles: Faces, n_frames: int) -> Sequence:
    """Bend a surface to and fro once, with noise along the normals that moves with it."""
    axis = int(np.ptp(rest, axis=0).argmax())
    low, high = rest[:, axis].min(), rest[:, axis].max()
    along = (rest[:, axis] - low) / (high - low)
    edges = local_edge_lengths(rest, triangles)
    amount = np.random.default_rng(SEED).normal(0.0, NOISE, len(rest)) * edges
    other = (axis + 1) % 3
    centre = rest.mean(axis=0)
    frames, normals = [], []
    for number in range(n_frames):
        angle = BEND * np.sin(2 * np.pi * number / n_frames) * along**2
        cosine, sine = np.cos(angle), np.sin(angle)
        clean = rest - centre
        a, b = clean[:, axis].copy(), clean[:, other].copy()
        clean[:, axis], clean[:, other] = cosine * a - sine * b, sine * a + cosine * b
        normals.append(vertex_normals(clean, triangles))
        frames.append(clean + amount[:, None] * normals[-1])
    return Sequence(np.array(frames), np.array(normals), edges, triangles)


def write_frames(sequence: Sequence, folder: Path) -> None:
    """Write the noisy frames as numbered files."""
    folder.mkdir()
    for number, positions in enumerate(sequence.frames, start=1):
        write_ply(folder / f"foot_{number:04d}.ply", positions, sequence.triangles, kind="double")


def fair_frames(given: Path, output: Path, arguments: list[str]) -> list[int]:
    """Fair all frames with the command line; give the number of steps of each."""
    report = output.with_suffix(".json")
    run_program("fair", given, "--sequence", "--out-dir", output, "--report", report, *arguments)
    return [mesh["steps"] for mesh in json.loads(report.read_text())["meshes"]]


def read_frames(folder: Path, n_frames: int) -> FloatArray:
    """Read the faired frames, (f, n, 3)."""
    paths = [folder / f"foot_{number:04d}.ply" for number in range(1, n_frames + 1)]
    return np.array([meshio.read(path).points for path in paths], dtype=np.float64)


def figures(removed: FloatArray, steps: list[int]) -> list[str]:
    """Describe a run for the table."""
    amounts = rms(removed)
    total = np.sqrt((removed**2).mean())
    jump = np.abs(np.diff(amounts)).max() / total
    change = rms(np.diff(removed, axis=0)) / total
    low, high = min(steps), max(steps)
    return [
        str(low) if low == high else f"{low} to {high}", f"{total:.4f}",
        f"{100 * jump:.2f} %", f"{100 * change.mean():.2f} %", f"{100 * change.max():.2f} %",
    ]  # fmt: skip


def rms(values: FloatArray) -> FloatArray:
    """Root of the mean square of every row."""
    return np.sqrt((values**2).mean(axis=1))


if __name__ == "__main__":
    sys.exit(main())
