"""Malformed files of every format: each is faired or refused in one line, nothing is lost."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "attack.py"


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [0, 1])
def test_no_malformed_file_does_harm(seed):
    command = [sys.executable, SCRIPT, "--count", "500", "--seed", str(seed)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
    assert "0 problems" in result.stdout
