"""Measure the peak memory of solves against the estimate made before them.

    python benchmarks/memory.py [NAME ...]

Each solve runs in a process of its own; what Python, numpy and scipy take before it is not counted.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
for folder in (ROOT / "tests", ROOT):
    sys.path.insert(0, str(folder))

from support import bad_meshes, meshes  # noqa: E402  the search path has to be set before

from adaptive_fairing.core import FairingSettings, PreparedMesh, denoise, fair  # noqa: E402
from adaptive_fairing.core.problem.prepared_mesh import DEFAULT_TOLERANCE  # noqa: E402

# Meshes with the tolerance of the paper's integrals, or None to denoise them.
CASES = {
    "sphere 5": (lambda: meshes.icosphere(5), 1e-3),
    "sphere 6": (lambda: meshes.icosphere(6), 1e-3),
    "sphere 7": (lambda: meshes.icosphere(7), 1e-3),
    "sphere 5, tight": (lambda: meshes.icosphere(5), 1e-6),
    "sphere 5, denoise": (lambda: meshes.noisy_ball(5, 0.003), None),
    "sphere 6, denoise": (lambda: meshes.noisy_ball(6, 0.001), None),
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
    print(f"{'case':20} {'triangles':>9} {'estimate MB':>11} {'measured MB':>11} {'ratio':>6}")
    for name in sys.argv[1:] or CASES:
        row = json.loads(
            subprocess.run(
                [sys.executable, __file__, "--measure", name],
                capture_output=True,
                check=True,
                text=True,
            ).stdout
        )
        estimate, measured = row["estimate"] / 1e6, row["measured"] / 1e6
        print(
            f"{name:20} {row['triangles']:9} {estimate:11.0f} {measured:11.0f} "
            f"{estimate / measured:6.2f}"
        )
    return 0


def measure(name: str) -> dict[str, float]:
    """Solve a case in this process; give the estimate and the rise of the peak memory."""
    make, tolerance = CASES[name]
    vertices, faces = make()
    before = _peak()
    if tolerance is None:
        denoise(vertices, faces)
    else:
        fair(vertices, faces, FairingSettings(steps=2, quadrature_tolerance=tolerance))
    measured = _peak() - before
    prepared = PreparedMesh(vertices, faces, quadrature_tolerance=tolerance or DEFAULT_TOLERANCE)
    estimate = prepared.needed_bytes("denoise" if tolerance is None else "fair")
    return {"triangles": len(faces), "estimate": estimate, "measured": measured}


def _peak() -> int:
    status = Path("/proc/self/status")
    if status.exists():
        # Not the resource usage: that begins with the peak of the process that started this one.
        (line,) = (text for text in status.read_text().splitlines() if text.startswith("VmHWM"))
        return 1024 * int(line.split()[1])
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


if __name__ == "__main__":
    if sys.argv[1:2] == ["--measure"]:
        print(json.dumps(measure(sys.argv[2])))
    else:
        sys.exit(main())
