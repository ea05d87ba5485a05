"""The code on the pages runs, and the command lines on them are understood."""

from __future__ import annotations

import re
import shlex

import numpy as np
import pytest
from support.meshes import icosphere
from support.pages import blocks

from adaptive_fairing.cli.arguments import parse

PYTHON = [block for block in blocks("python") if "import bpy" not in block.text]
COMMANDS = [
    pytest.param(line, id=f"{block}: {line[:60]}")
    for block in blocks("sh")
    for line in block.text.replace("\\\n", " ").splitlines()
    if "adaptive-fairing " in line
]


@pytest.fixture
def mesh():
    """Give a sphere with noise."""
    vertices, faces = icosphere(3)
    noise = np.random.default_rng(3).normal(0.0, 0.02, len(vertices))
    return {"vertices": vertices * (1.0 + noise[:, None]), "faces": faces}


def test_the_pages_have_examples():
    assert len(PYTHON) > 5
    assert len(COMMANDS) > 5


@pytest.mark.parametrize("block", PYTHON, ids=str)
def test_an_example_of_the_core_runs(block, mesh):
    exec(compile(block.text, str(block), "exec"), mesh)


@pytest.mark.parametrize("line", COMMANDS)
def test_a_command_line_is_understood(line, tmp_path, monkeypatch):
    """Its options exist and go together; the files that it names stand there."""
    command = line.split("#")[0].split("&&")[-1]
    wrapped = re.search(r"--wrap '(.*)'", command)
    if wrapped:
        command = wrapped[1].replace("$SLURM_ARRAY_TASK_ID", "1")
    words = shlex.split(command.split(":::")[0])
    words = [word.replace("{}", "1") for word in words[words.index("adaptive-fairing") + 1 :]]
    monkeypatch.chdir(tmp_path)
    for name in ("scan.ply", "scan.obj", "part.stl", "dance.abc", "cloth_1.ply", "cloth_2.ply"):
        (tmp_path / name).touch()
    for folder in ("scans", "more/deep", "assets"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "scans" / "one.ply").touch()
    (tmp_path / "more" / "deep" / "two.obj").touch()
    parse(words)
