"""Malformed files of every format: each is faired or refused in one line, nothing is lost."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.thorough
def test_no_malformed_file_does_harm():
    command = [sys.executable, "-m", "benchmarks.attack", "--count", "500", "--seed", "0"]
    result = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert result.returncode == 0, result.stdout
    assert "0 problems" in result.stdout
