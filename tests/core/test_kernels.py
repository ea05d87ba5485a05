"""Other processors have other BLAS kernels and numbers of threads; results are the same."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support import meshes

# In units of an edge: far below what anybody sees, far above what sums in another order change.
BOUND = 1e-6

PROGRAM = """
import sys
import numpy as np
from support import meshes
from adaptive_fairing.core import denoise, fair
vertices, faces = meshes.noisy_ball(4, 0.01)
for solve in (denoise, fair):
    sys.stdout.buffer.write(solve(vertices, faces).positions.tobytes())
"""


def _features() -> set[str]:
    """Instruction sets of this processor, as far as Linux tells."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return set()
    return {word for line in text.splitlines() if line.startswith("flags") for word in line.split()}


# A kernel that the processor lacks instructions for would crash.
NEEDED = {"Prescott": "pni", "Haswell": "avx2", "Zen": "avx2", "SkylakeX": "avx512dq"}
SETTINGS = [
    {"OPENBLAS_CORETYPE": kernel} for kernel, needed in NEEDED.items() if needed in _features()
] + [{"OPENBLAS_NUM_THREADS": "1"}, {"OPENBLAS_NUM_THREADS": "64"}]


@cache
def results(settings: tuple[tuple[str, str], ...]) -> np.ndarray:
    finished = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        # Beside a bpy module scipy comes by the search path. The other variables stay as they are:
        # on some virtual machines OpenBLAS must be told the size of a cache, or it crashes.
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), **dict(settings)},
        capture_output=True,
        check=False,
    )
    assert finished.returncode == 0, finished.stderr.decode()
    return np.frombuffer(finished.stdout).reshape(2, -1, 3)


@pytest.mark.skipif(sys.platform == "win32", reason="the variables are those of OpenBLAS on Linux")
@pytest.mark.parametrize("settings", SETTINGS, ids=lambda each: "=".join(next(iter(each.items()))))
def test_results_agree_on_every_kernel(settings):
    vertices, faces = meshes.noisy_ball(4, 0.01)
    edge = np.linalg.norm(vertices[faces[:, 0]] - vertices[faces[:, 1]], axis=1).mean()
    difference = np.abs(results(tuple(settings.items())) - results(()))
    assert difference.max() < BOUND * edge
