"""Measure the peak memory of solves against the estimate made before them.

    python -m benchmarks.memory [NAME ...]

Each solve runs in a process of its own; what Python, numpy and scipy take before it is not counted.
"""

from __future__ import annotations

import json
import subprocess
import sys

from adaptive_fairing.core import FairingSettings, PreparedMesh, denoise, fair
from adaptive_fairing.core.problem.prepared_mesh import DEFAULT_TOLERANCE
from tests.support import bad_meshes, meshes

from .measuring import peak_memory, table

# Meshes with the tolerance of the paper's integrals, or None to denoise them.
CASES = {
    "sphere 5": (lambda: meshes.icosphere(5), 1e-3),
    "sphere 6": (lambda: meshes.icosphere(6), 1e-3),
    "sphere 7": (lambda: meshes.icosphere(7), 1e-3),
    "sphere 5, tight": (lambda: meshes.icosphere(5), 1e-6),
    "sphere 5, denoise": (lambda: meshes.noisy_ball(5, 0.003), None),
    "sphere 6, denoise": (lambda: meshes.noisy_ball(6, 0.001), None),
    "sphere 7, denoise": (lambda: meshes.noisy_ball(7, 0.0005), None),
    "irregular": (lambda: meshes.random_closed(1), 1e-3),
    "irregular, tight": (lambda: meshes.random_closed(1), 1e-6),
    "grid": (lambda: meshes.flat_grid(200, 200), 1e-3),
    "all wrong": (bad_meshes.everything_wrong, 1e-3),
    "poles of 100": (lambda: meshes.latlong_sphere(100, 100), 1e-3),
    "bipyramid of 200": (lambda: meshes.bipyramid(200), 1e-3),
    "bipyramid of 400": (lambda: meshes.bipyramid(400), 1e-3),
}


def main() -> int:
    """Print a row for every case, or for those that are named."""
    rows = []
    for name in sys.argv[1:] or CASES:
        command = [sys.executable, "-m", "benchmarks.memory", "--measure", name]
        done = subprocess.run(command, capture_output=True, check=True, text=True)
        triangles, estimate, measured = json.loads(done.stdout)
        megabytes = [f"{size / 1e6:.0f}" for size in (estimate, measured)]
        rows.append([name, str(triangles), *megabytes, f"{estimate / measured:.2f}"])
    print(table(["case", "triangles", "estimate MB", "measured MB", "ratio"], rows))
    return 0


def measure(name: str) -> tuple[int, int, int]:
    """Solve a case here; return its triangles, the estimate and the rise of the peak memory."""
    make, tolerance = CASES[name]
    vertices, faces = make()
    before = peak_memory()
    if tolerance is None:
        denoise(vertices, faces)
    else:
        fair(vertices, faces, FairingSettings(steps=2, quadrature_tolerance=tolerance))
    measured = peak_memory() - before
    prepared = PreparedMesh(vertices, faces, quadrature_tolerance=tolerance or DEFAULT_TOLERANCE)
    estimate = prepared.needed_bytes("denoise" if tolerance is None else "fair")
    return len(faces), estimate, measured


if __name__ == "__main__":
    if sys.argv[1:2] == ["--measure"]:
        print(json.dumps(measure(sys.argv[2])))
    else:
        sys.exit(main())
