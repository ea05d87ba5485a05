"""The shell steps of the workflows: they are valid, and name files that exist."""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MADE_BY_A_STEP = ("dist",)


def steps() -> list[str]:
    """Return every ``run:`` of the workflows; a folded one on the lines below it."""
    found = []
    for path in sorted((ROOT / ".github" / "workflows").glob("*.yml")):
        for folded, plain in re.findall(
            r"- run: (?:>-\n((?: {10}.*\n)+)|(.+))", path.read_text("utf-8")
        ):
            text = " ".join(folded.split()) or re.sub(r'^"(.*)"$', r"\1", plain)
            found.append(re.sub(r"\$\{\{.*?\}\}", "VALUE", text))
    assert len(found) > 20
    return sorted(set(found))


@pytest.mark.parametrize("step", steps())
def test_a_step_is_valid_shell(step):
    subprocess.run(["bash", "-n", "-c", step], check=True)


@pytest.mark.parametrize("step", steps())
def test_a_step_names_files_that_exist(step):
    for word in shlex.split(step):
        if re.fullmatch(r"[\w.]+(/[\w.]+)+", word) and not word.startswith(MADE_BY_A_STEP):
            assert (ROOT / word).exists(), word
