"""Shared test set-up: which ``adaptive_fairing`` the tests import. Must not import bpy.

The repository root is itself an importable package (its ``__init__.py`` is the entry point that
Blender asks for). A clone in a folder that happens to be called ``adaptive_fairing`` would thus
hide the real package behind that entry point; the root goes first on the search path and the
package is imported here, before pytest imports any test module, to settle the name.
"""

import sys
from pathlib import Path

TESTS = Path(__file__).resolve().parent

for folder in (TESTS, TESTS.parent):  # the last one inserted is searched first
    sys.path.insert(0, str(folder))

import adaptive_fairing  # noqa: E402, F401  the search path has to be set before
