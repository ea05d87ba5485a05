"""Messages of the command line where Blender is not installed."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from adaptive_fairing.cli.main import PYTHONS_WITH_BPY

ROOT = Path(__file__).resolve().parents[2]


THIS = sys.version_info[:2]


@pytest.mark.parametrize(
    ("pythons", "expected"),
    [
        ((THIS,), 'Blender is missing: pip install bpy, or the extra "blender" of this package'),
        (
            ((3, 9), (3, 10)),
            f"exists for Python 3.9 and 3.10, and this is {THIS[0]}.{THIS[1]}; install into one",
        ),
    ],
)
def test_it_says_which_pythons_have_blender(tmp_path, pythons, expected):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    program = (
        "import sys; sys.modules['bpy'] = None\n"
        "from adaptive_fairing.cli import main\n"
        f"main.PYTHONS_WITH_BPY = {pythons}\n"
        "sys.exit(main.main(['denoise', 'a.obj', '-o', 'b.obj']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert expected in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_they_are_those_of_the_package():
    extra = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    named = [each for each in extra["optional-dependencies"]["blender"] if each.startswith("bpy")]
    pythons = [".".join(map(str, version)) for version in PYTHONS_WITH_BPY]
    assert [each.partition("python_version == ")[2].strip("'") for each in named] == pythons
