"""The installed zip lives and dies in a Blender of its own, in processes of its own.

This is the Blender of this Python; tools/compatibility_matrix.py does the same in all of them.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import build_extension
from compatibility_matrix import CHECK, ROOT, Row, check_blender

pytest.importorskip("bpy", reason="needs the bpy module")


@pytest.fixture(scope="module")
def row(tmp_path_factory) -> Row:
    work = tmp_path_factory.mktemp("installed")
    plain = build_extension.build(
        [build_extension.NO_WHEELS], tmp_path_factory.mktemp("zip"), wheels=Path("unused")
    )[0]
    filled = Row("this Blender")
    check_blender(
        filled,
        [sys.executable, str(CHECK)],
        [sys.executable, "-m", "adaptive_fairing"],
        work,
        archive=plain,
        plain=plain,
        PYTHONPATH=str(ROOT),
    )
    return filled


def test_the_installed_extension_passes_every_check(row):
    assert not row.failures, "\n\n".join(row.failures)
    assert row.cells["scipy origin"] == "own"
    assert row.cells["command"] == "0 1 2"
