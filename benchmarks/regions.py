"""What a run on a small part of a mesh costs, and a second one: in parts of a run on the whole.

Processor time, the least of several turns, in which all runs take part one after the other:

    python -m benchmarks.regions --triangles 82000 --part 0.01
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from adaptive_fairing.core import PreparedMesh, denoise, fair

from . import meshes


def processor_seconds(run: Callable[[], object]) -> float:
    """Measure one run."""
    started = time.process_time()
    run()
    return time.process_time() - started


def weights_around(vertices: np.ndarray, place: int, part: float) -> np.ndarray:
    """Weights (n,) of 1 at a part of the vertices, those nearest to one of them."""
    distance = np.linalg.norm(vertices - vertices[place], axis=1)
    return (distance < np.quantile(distance, part)).astype(float)


def main() -> None:
    """Print a row for each algorithm and kind of run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, default=82_000)
    parser.add_argument("--part", type=float, default=0.01, help="of the vertices")
    parser.add_argument("--turns", type=int, default=3)
    arguments = parser.parse_args()
    _, vertices, faces = meshes.irregular(arguments.triangles)
    here, there = (weights_around(vertices, k, arguments.part) for k in (0, len(vertices) // 2))
    for name, algorithm in (("fair", fair), ("denoise", denoise)):
        prepared = PreparedMesh(vertices, faces)
        algorithm(vertices, faces, prepared=prepared)
        runs = {
            "whole": {},
            "whole, second run": {"prepared": prepared},
            "part": {"weights": here},
            "part, mesh known": {"weights": there, "prepared": prepared},
            "part, second run": {"weights": there, "prepared": prepared},
        }
        seconds = {kind: np.inf for kind in runs}
        for _ in range(arguments.turns):
            prepared.region(vertices, np.zeros(len(vertices), dtype=bool), 1)  # forgets the last
            for kind, options in runs.items():

                def run(algorithm=algorithm, options=options):
                    return algorithm(vertices, faces, **options)

                seconds[kind] = min(seconds[kind], processor_seconds(run))
        for kind, least in seconds.items():
            print(f"{name}, {kind}: {least:.3f} s, {least / seconds['whole']:.3f}", flush=True)


if __name__ == "__main__":
    main()
