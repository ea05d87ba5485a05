"""Profile of a step and of denoise by module, and its distance from the machine's limit.

A thread looks many times a second at what all threads of the core do, and counts it by module. In
a table a module has the part of the looks that found a thread in it, functions of other packages
that it calls included.

The limit is the time in which this machine could do what a step cannot avoid:

    arithmetic   the matrix products of evaluation, local matrices and right side,
                 at the rate of a large matrix product on all cores
    traffic      every array that does not fit the cache read or written once per use,
                 at the rate of copying a large array on all cores

It has neither the arithmetic between the products nor the irregular access of the scatter, and it
takes the matrix as it is stored, read once per iteration for all three coordinates. All counts as
in double precision, although large meshes are solved in single.

    python -m benchmarks.profile_step [--sizes 328000] [--mesh FILE] [--repeats 5]
"""

from __future__ import annotations

import argparse
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from types import FrameType
from typing import NamedTuple

import numpy as np

import adaptive_fairing.core
from adaptive_fairing.core import FairingSettings, TriangleTopology, denoise, fair_steps
from adaptive_fairing.core.linalg.symmetric_pattern import SymmetricPattern
from adaptive_fairing.core.loop.basis import basis_table
from adaptive_fairing.core.loop.patches import PatchSet
from adaptive_fairing.core.loop.quadrature import quadrature_choice
from adaptive_fairing.core.runtime.threads import n_threads

from . import meshes
from .measuring import best_time, load, machine, seconds_text, table

CORE = Path(adaptive_fairing.core.__file__).parent

WAITING = "runtime.threads"
"""Module in which the main thread waits for the others."""

PROFILED = ("set-up and first step", "second step", "denoise")

PAUSE = 0.001
"""Seconds between two looks."""

COPIED_BYTES = 1 << 28
"""Size of the array whose copying measures the memory: far beyond any cache."""

GEMM_SIZE = 1536
"""Rows and columns of the matrices whose product measures the arithmetic."""


class Profile(NamedTuple):
    """Wall-clock and processor seconds of an action, and its looks by module of the core."""

    seconds: float
    processor: float
    looks: Counter[str]


class Rates(NamedTuple):
    """Peak of the machine: floating-point operations and bytes per second, on all cores."""

    arithmetic: float
    traffic: float


class Work(NamedTuple):
    """Least work of one step: floating-point operations, and bytes to and from memory."""

    operations: float
    transferred: float

    def seconds(self, rates: Rates) -> float:
        """Time of both, one after the other."""
        return self.operations / rates.arithmetic + self.transferred / rates.traffic


def profile(action: Callable[[], object]) -> tuple[object, Profile]:
    """Run an action of the core and see in which modules its threads are."""
    looks: Counter[str] = Counter()
    ended = threading.Event()

    def look() -> None:
        while not ended.wait(PAUSE):
            found = [_module(frame) for frame in sys._current_frames().values()]
            looks.update(
                [name for name in found if name not in (None, WAITING)] or {*found} - {None}
            )

    watcher = threading.Thread(target=look, daemon=True)
    watcher.start()
    start, processor = time.perf_counter(), time.process_time()
    try:
        result = action()
    finally:
        spent = time.perf_counter() - start, time.process_time() - processor
        ended.set()
        watcher.join()
    return result, Profile(*spent, looks)


def _module(frame: FrameType | None) -> str | None:
    """Name the innermost module of the core that a thread is in."""
    while frame is not None:
        path = Path(frame.f_code.co_filename)
        if CORE in path.parents:
            return ".".join(path.relative_to(CORE).with_suffix("").parts)
        frame = frame.f_back
    return None


def profiles(mesh: meshes.Mesh, settings: FairingSettings) -> tuple[list[Profile], int]:
    """Profile all of `PROFILED`; return the iterations of the second step, too."""
    steps = fair_steps(mesh.vertices, mesh.triangles, settings)
    _, first = profile(lambda: next(steps))
    step, second = profile(lambda: next(steps))
    _, denoised = profile(lambda: denoise(mesh.vertices, mesh.triangles))
    return [first, second, denoised], step.solve.iterations


def measured_rates(repeats: int) -> Rates:
    """Measure a large matrix product and the copying of a large array; the fastest run counts."""
    a = np.random.default_rng(0).normal(size=(GEMM_SIZE, GEMM_SIZE))
    out = np.empty_like(a)
    gemm = best_time(lambda: np.matmul(a, a, out=out), repeats)

    source = np.ones(COPIED_BYTES // 8)
    target = np.empty_like(source)
    bounds = np.linspace(0, len(source), n_threads() + 1).astype(int)
    pieces = [slice(*each) for each in pairwise(bounds)]

    def copy(piece: slice) -> None:
        target[piece] = source[piece]

    with ThreadPoolExecutor(len(pieces)) as pool:
        copying = best_time(lambda: list(pool.map(copy, pieces)), repeats)
    return Rates(2 * GEMM_SIZE**3 / gemm, 2 * COPIED_BYTES / copying)


def unavoidable_work(mesh: meshes.Mesh, settings: FairingSettings, iterations: int) -> Work:
    """Count the operations and the bytes of one step, see the head of this file."""
    topology = TriangleTopology(mesh.triangles, len(mesh.vertices))
    patches = PatchSet(topology)
    choice = quadrature_choice(settings.quadrature_tolerance)
    points = np.array([basis_table(c, choice)[0].shape[1] for c in patches.classes])
    members = np.bincount(
        [s.class_index for s in patches.segments],
        [len(s.triangles) for s in patches.segments],
        minlength=len(points),
    )
    control = patches.n_control_points
    pairs = control * (control + 1) // 2
    # Coordinates and timestep, first and second derivatives of the coordinates; then M X.
    evaluated = control * points * (4 + 6 + 9)
    operations = 2 * members @ (evaluated + 4 * points * pairs + 3 * points * control)

    n, n_upper = topology.n_vertices, SymmetricPattern(topology.adjacency()).n_upper
    number, index = 8, 4
    assembly = index * (members @ (control + pairs))  # which vertices, which entries
    assembly += number * n * (4 + 3)  # positions and timestep, right side
    assembly += number * n_upper  # entries of the upper triangle, which are all there are
    # Per iteration A p; then x += a p, r -= a A p, z = r / d, p = z + b p and two products.
    iteration = (number + index) * n_upper + number * n * (3 * 14 + 1)
    return Work(float(operations), float(assembly + (iterations + 1) * iteration))


def report(mesh: meshes.Mesh, settings: FairingSettings, repeats: int) -> None:
    """Print the tables for one mesh."""
    rates = measured_rates(repeats)
    runs = [profiles(mesh, settings) for _ in range(repeats)]
    by_action = [list(found) for found in zip(*(found for found, _ in runs), strict=True)]
    best = [min(found, key=lambda each: each.seconds) for found in by_action]
    iterations = runs[0][1]
    print(f"\n## {mesh.name}, {len(mesh.triangles)} triangles (load {load()})\n")
    for title, found, fastest in zip(PROFILED, by_action, best, strict=True):
        looks = sum((each.looks for each in found), Counter())
        rows = [[name, f"{count / looks.total():.0%}"] for name, count in looks.most_common()]
        print(table([title, "part"], [row for row in rows if row[1] != "0%"]))
        spent = map(seconds_text, fastest[:2])
        print("\n{} s, {} s of all processors\n".format(*spent))

    work = unavoidable_work(mesh, settings, iterations)
    again = measured_rates(repeats)  # the machine may have been busy with other things before
    rates = Rates(*(max(pair) for pair in zip(rates, again, strict=True)))
    limit = work.seconds(rates)
    ratios = {
        "set-up / step": best[0].seconds / best[1].seconds,
        "step / limit": best[1].seconds / limit,
        "denoise / step": best[2].seconds / best[1].seconds,
    }
    print(
        f"{iterations} iterations; limit {seconds_text(limit)} s: "
        f"{work.operations / 1e9:.2f} Gflop at {rates.arithmetic / 1e9:.1f} Gflop/s, "
        f"{work.transferred / 1e9:.2f} GB at {rates.traffic / 1e9:.1f} GB/s"
    )
    for name, ratio in ratios.items():
        print(f"{name}: {ratio:.2f}")


def main() -> None:
    """Profile every mesh asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    meshes.add_arguments(parser, sizes=[328_000])
    parser.add_argument("--repeats", type=int, default=5, help="the fastest run counts")
    arguments = parser.parse_args()
    print(machine())
    for mesh in meshes.chosen(arguments):
        settings = meshes.comparable_settings(mesh, arguments.radius)
        report(mesh, settings, arguments.repeats)


if __name__ == "__main__":
    main()
