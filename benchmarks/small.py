"""How quick small meshes are, and what many patch classes cost against few.

Each run is a process of its own, timed after the import: set-up and four steps. "first" is the
first run in the process, which also builds the tables of the patch classes; "again" is the best of
the following ones.

The same number of triangles can mean more work: a triangle whose corners have the valences a, b, c
has a + b + c - 6 control points, and uneven meshes need more iterations. So "elements" is the time
without the solves, of the set-up of the space and four assemblies, and the last line puts it in
relation to the number of entries of the local matrices.

    python benchmarks/small.py [--sizes 5000 50000] [--classes 300] [--repeats 5] [--record]
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import history
import meshes
import numpy as np
from measuring import (
    Stopwatch,
    announced,
    best_time,
    describe,
    load,
    machine,
    seconds_text,
    table,
)

from adaptive_fairing.core import FairingSettings, LoopSpace, TriangleTopology, fair
from adaptive_fairing.core.loop.patches import PatchSet

RUNS_IN_PROCESS = 3

RADIUS = 2.0
"""Smoothing radius of all steps together, in local edges."""


def with_classes(n_triangles: int, n_classes: int) -> meshes.Mesh:
    """Make an irregular mesh with about `n_classes` patch classes.

    Vertices put into the middle of random triangles raise the valences around; their share is
    searched for.
    """
    low, high = 0.0, 0.45
    for _ in range(12):
        share = (low + high) / 2
        mesh = _with_vertices_inside(n_triangles, share)
        if _count_classes(mesh) < n_classes:
            low = share
        else:
            high = share
    return mesh


def _with_vertices_inside(n_triangles: int, share: float) -> meshes.Mesh:
    """Split a share of all triangles into three; the result has `n_triangles` or one less."""
    n_split = round(share * n_triangles / (1 + 2 * share))
    base = meshes.irregular(n_triangles - 2 * n_split)
    chosen = np.random.default_rng(3).choice(len(base.triangles), n_split, replace=False)
    split = base.triangles[chosen]
    centres = base.vertices[split].mean(axis=1)
    new = len(base.vertices) + np.arange(n_split)
    parts = [np.stack([split[:, k], split[:, (k + 1) % 3], new], axis=1) for k in range(3)]
    whole = np.delete(base.triangles, chosen, axis=0)
    triangles = np.concatenate([whole, *parts]).astype(np.int32)
    return meshes.Mesh("many classes", np.concatenate([base.vertices, centres]), triangles)


def _patches(mesh: meshes.Mesh) -> PatchSet:
    return PatchSet(TriangleTopology(mesh.triangles, len(mesh.vertices)))


def _count_classes(mesh: meshes.Mesh) -> int:
    return len(_patches(mesh).classes)


def mean_pairs(mesh: meshes.Mesh) -> float:
    """Entries of a local matrix, on average over the triangles: what a step's work grows with."""
    patches = _patches(mesh)
    counts = patches.n_control_points * (patches.n_control_points + 1) / 2
    members = [len(segment.triangles) for segment in patches.segments]
    classes = [segment.class_index for segment in patches.segments]
    return float(np.average(counts[classes], weights=members))


def run_here(path: Path, tau: float) -> None:
    """Time runs in this process, and print them as JSON."""
    mesh = meshes.read_ply(path)
    settings = FairingSettings(tau=tau)
    watch = Stopwatch()
    result = fair(mesh.vertices, mesh.triangles, settings)
    first = watch.seconds()
    again = best_time(lambda: fair(mesh.vertices, mesh.triangles, settings), RUNS_IN_PROCESS)
    topology = TriangleTopology(mesh.triangles, len(mesh.vertices))

    def elements() -> None:
        space = LoopSpace(topology, settings.quadrature_tolerance)
        for _ in range(settings.steps):
            space.step_system(mesh.vertices)

    times = {"first": first, "again": again, "elements": best_time(elements, RUNS_IN_PROCESS)}
    iterations = sum(step.solve.iterations for step in result.steps)
    print(json.dumps({**times, "iterations": iterations}))


def contest(chosen: list[meshes.Mesh], repeats: int) -> list[dict[str, float]]:
    """Run all meshes in turns, each run in a new process; the best times of each."""
    runs: list[list[dict]] = [[] for _ in chosen]
    with tempfile.TemporaryDirectory() as folder:
        commands = []
        for k, mesh in enumerate(chosen):
            path = Path(folder) / f"{k}.ply"
            meshes.write_ply(mesh, path)
            tau = meshes.comparable_settings(mesh, RADIUS).tau
            commands.append([sys.executable, __file__, "--run", str(path), "--tau", repr(tau)])
        for turn in range(repeats):
            for command, done in zip(commands, runs, strict=True):
                with announced(f"run {turn + 1} of {repeats}"):
                    process = subprocess.run(command, capture_output=True, text=True, check=True)
                done.append(json.loads(process.stdout))
    return [{key: min(run[key] for run in done) for key in done[0]} for done in runs]


def report(size: int, n_classes: int, repeats: int) -> dict[str, float]:
    """Print the table for one size; return the ratios to be recorded."""
    few, many = meshes.sphere(size), with_classes(size, n_classes)
    times = contest([few, many], repeats)
    pairs = [mean_pairs(mesh) for mesh in (few, many)]
    rows = [
        [
            mesh.name,
            str(len(mesh.triangles)),
            str(_count_classes(mesh)),
            f"{pair:.0f}",
            str(time["iterations"]),
            seconds_text(time["first"]),
            seconds_text(time["again"]),
            seconds_text(time["elements"]),
        ]
        for mesh, pair, time in zip((few, many), pairs, times, strict=True)
    ]
    print(f"\n## {size} triangles, set-up and four steps (load {load()})\n")
    header = [
        "",
        "triangles",
        "classes",
        "entries",
        "iterations",
        "first s",
        "again s",
        "elements s",
    ]
    print(table(header, rows))
    few_cost, many_cost = (
        time["elements"] / len(mesh.triangles)
        for mesh, time in zip((few, many), times, strict=True)
    )
    cost, work = many_cost / few_cost, pairs[1] / pairs[0]
    print(
        f"elements, many classes over few: {cost:.2f} times the time, {work:.2f} times the entries"
    )
    return {
        f"{size}: many classes / few": cost,
        f"{size}: many classes / few, by entries": cost / work,
        f"{size}: first / again": times[0]["first"] / times[0]["again"],
    }


def main() -> None:
    """Measure all sizes asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="*", default=[5_000, 50_000])
    parser.add_argument("--classes", type=int, default=300)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--run", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--tau", type=float, help=argparse.SUPPRESS)
    history.add_arguments(parser)
    arguments = parser.parse_args()
    if arguments.run is not None:
        run_here(arguments.run, arguments.tau)
        return
    details = machine()
    print(describe(details))
    ratios: dict[str, float] = {}
    for size in arguments.sizes:
        ratios |= report(size, arguments.classes, arguments.repeats)
    history.finish(arguments, "small", details, ratios)


if __name__ == "__main__":
    main()
