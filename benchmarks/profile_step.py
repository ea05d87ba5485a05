"""Where the time of the set-up and of one step goes, and how far a step is from what must be.

The limit is the time in which this machine could do what a step cannot avoid:

    arithmetic   the matrix products of evaluation, local matrices and right side,
                 at the rate of a large matrix product on all cores
    traffic      every array that does not fit the cache read or written once per use,
                 at the rate of copying a large array on all cores

It has neither the arithmetic between the products nor the irregular access of the scatter, and it
takes the matrix as it is stored, read once per iteration for all three coordinates. All counts as
in double precision, although large meshes are solved in single.

    python benchmarks/profile_step.py [--sizes 328000] [--mesh FILE] [--repeats 5] [--record]
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import history
import meshes
import numpy as np
from measuring import (
    announced,
    best_time,
    describe,
    load,
    machine,
    seconds_text,
    table,
    usable_cores,
)
from stages import SETUP, STEP, Clock, Stage

from adaptive_fairing.core import FairingSettings, TriangleTopology, fair_steps
from adaptive_fairing.core.linalg.symmetric_pattern import SymmetricPattern
from adaptive_fairing.core.loop.basis import basis_table
from adaptive_fairing.core.loop.patches import PatchSet
from adaptive_fairing.core.loop.quadrature import quadrature_choice

REST = "everything else"

COPIED_BYTES = 1 << 28
"""Size of the array whose copying measures the memory: far beyond any cache."""

GEMM_SIZE = 1536
"""Rows and columns of the matrices whose product measures the arithmetic."""


class Stages(NamedTuple):
    """Seconds by stage, wall-clock and of all threads' processors; the last stage is `REST`."""

    seconds: dict[str, float]
    processor: dict[str, float]

    @property
    def total(self) -> float:
        """Wall-clock time of all stages."""
        return sum(self.seconds.values())


class Profile(NamedTuple):
    """One run: where the time of the set-up and of a step went."""

    setup: Stages
    step: Stages
    iterations: int


class Rates(NamedTuple):
    """What the machine can do: floating-point operations and bytes per second, on all cores."""

    arithmetic: float
    traffic: float


class Work(NamedTuple):
    """What one step cannot avoid: floating-point operations, and bytes to and from memory."""

    operations: float
    transferred: float

    def seconds(self, rates: Rates) -> float:
        """Time of both, one after the other."""
        return self.operations / rates.arithmetic + self.transferred / rates.traffic


def profile(mesh: meshes.Mesh, settings: FairingSettings) -> Profile:
    """Run the set-up and two steps, and see where their time went."""
    clock = Clock()

    def now() -> tuple[Counter[str], Counter[str]]:
        """Read all clocks."""
        return (
            clock.seconds + Counter({REST: time.perf_counter()}),
            clock.processor + Counter({REST: time.process_time()}),
        )

    with clock.watching((*SETUP, *STEP)):
        steps = fair_steps(mesh.vertices, mesh.triangles, settings)
        at_start = now()
        next(steps)
        at_first = now()
        second = next(steps)
        at_second = now()
    return Profile(
        # Until the first step is out, the set-up and the stages of one step and a half are done.
        Stages(*(_difference(a, b, SETUP) for a, b in zip(at_start, at_first, strict=True))),
        Stages(*(_difference(a, b, STEP) for a, b in zip(at_first, at_second, strict=True))),
        second.solve.iterations,
    )


def _difference(
    before: Counter[str], after: Counter[str], stages: tuple[Stage, ...]
) -> dict[str, float]:
    """Take the times of stages between two moments, and as `REST` what none accounts for."""
    spent = {name: after[name] - before[name] for name in after}
    rest = 2 * spent[REST] - sum(spent.values())
    return {stage.label: spent.get(stage.label, 0.0) for stage in stages} | {REST: rest}


def measured_rates() -> Rates:
    """Measure a large matrix product and the copying of a large array."""
    a = np.random.default_rng(0).normal(size=(GEMM_SIZE, GEMM_SIZE))
    out = np.empty_like(a)
    gemm = best_time(lambda: np.matmul(a, a, out=out), 5)

    source = np.ones(COPIED_BYTES // 8)
    target = np.empty_like(source)
    parts = np.array_split(np.arange(len(source)), usable_cores())
    pieces = [slice(part[0], part[-1] + 1) for part in parts]

    def copy(piece: slice) -> None:
        target[piece] = source[piece]

    with ThreadPoolExecutor(len(pieces)) as pool:
        copying = best_time(lambda: list(pool.map(copy, pieces)), 5)
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


def report(mesh: meshes.Mesh, settings: FairingSettings, repeats: int) -> dict[str, float]:
    """Print the tables for one mesh; return the ratios to be recorded."""
    rates = measured_rates()
    runs = []
    for k in range(repeats):
        with announced(f"{mesh.name}: run {k + 1} of {repeats}"):
            runs.append(profile(mesh, settings))
    setup = min((run.setup for run in runs), key=lambda stages: stages.total)
    step = min((run.step for run in runs), key=lambda stages: stages.total)
    print(f"\n## {mesh.name}, {len(mesh.triangles)} triangles (load {load()})\n")
    for title, stages in (("set-up", setup), ("one step", step)):
        rows = [
            [
                name,
                seconds_text(seconds),
                f"{seconds / stages.total:.0%}",
                seconds_text(stages.processor[name]),
            ]
            for name, seconds in stages.seconds.items()
        ]
        processor = seconds_text(sum(stages.processor.values()))
        rows.append(["all", seconds_text(stages.total), "100%", processor])
        print(table([title, "s", "share", "processor s"], rows), "\n")

    iterations = runs[0].iterations
    work = unavoidable_work(mesh, settings, iterations)
    again = measured_rates()  # the machine may have been busy with other things before
    rates = Rates(*(max(pair) for pair in zip(rates, again, strict=True)))
    limit = work.seconds(rates)
    ratios = {
        "set-up / step": setup.total / step.total,
        "step / limit": step.total / limit,
    }
    print(
        f"{iterations} iterations; limit {seconds_text(limit)} s: "
        f"{work.operations / 1e9:.2f} Gflop at {rates.arithmetic / 1e9:.1f} Gflop/s, "
        f"{work.transferred / 1e9:.2f} GB at {rates.traffic / 1e9:.1f} GB/s"
    )
    for name, ratio in ratios.items():
        print(f"{name}: {ratio:.2f}")
    return {f"{mesh.name} {len(mesh.triangles)}: {name}": r for name, r in ratios.items()}


def main() -> None:
    """Profile every mesh asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    meshes.add_arguments(parser, sizes=[328_000])
    parser.add_argument("--repeats", type=int, default=5, help="the fastest run counts")
    history.add_arguments(parser)
    arguments = parser.parse_args()
    details = machine()
    print(describe(details))
    ratios: dict[str, float] = {}
    for mesh in meshes.chosen(arguments):
        settings = meshes.comparable_settings(mesh, arguments.radius)
        ratios |= report(mesh, settings, arguments.repeats)
    history.finish(arguments, "profile", details, ratios)


if __name__ == "__main__":
    main()
