"""The core stands alone: numpy, scipy and the standard library, never bpy."""

import ast
import subprocess
import sys
from pathlib import Path

from adaptive_fairing import core

ROOT = Path(__file__).resolve().parents[2]

# Blender is blocked, not only absent; a new process, for other tests of a session may load bpy.
PROGRAM = """
import sys
sys.modules["bpy"] = None
import adaptive_fairing.core as core
import numpy as np
vertices = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
core.fair(vertices, np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]))
"""


def test_core_runs_where_bpy_cannot_be_imported():
    finished = subprocess.run(
        [sys.executable, "-c", PROGRAM], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert finished.returncode == 0, finished.stderr


def test_core_imports_numpy_scipy_and_the_standard_library_only():
    """Everywhere, functions included. What it imports of this project, import-linter checks."""
    modules = sorted((ROOT / "adaptive_fairing" / "core").rglob("*.py"))
    assert modules
    for module in modules:
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module]
            for name in names:
                top = name.partition(".")[0]
                assert top in sys.stdlib_module_names | {"numpy", "scipy"}, (module.name, name)


def test_public_names_are_those_that_scripts_rely_on():
    for name in (
        "denoise DenoiseSettings DenoiseResult "
        "FairingSettings fair_steps fair FairingStep FairingResult SolveReport SurfaceMeasures "
        "TriangleTopology LoopSpace mesh_density FairingError"
    ).split():
        assert name in core.__all__
        assert hasattr(core, name)
