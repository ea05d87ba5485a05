"""The pip package: wheel and sdist build, install in a clean environment, and do the main job.

pip fetches what the package depends on, so these tests need a package registry.
"""

from __future__ import annotations

import os
import subprocess
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from adaptive_fairing.version import program_version

pytestmark = pytest.mark.thorough

ROOT = Path(__file__).resolve().parents[2]
PACKAGED = (".py", ".json", ".typed")
VERTICES = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, -1.5]]
TRIANGLES = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1), (5, 2, 1), (5, 3, 2), (5, 4, 3), (5, 1, 4)]
OCTAHEDRON = "".join(
    [f"v {x} {y} {z}\n" for x, y, z in VERTICES]
    + [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in TRIANGLES]
)


def run(*command: str | Path, cwd: Path) -> str:
    """Run a command outside of the repository and return what it printed."""
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        list(map(str, command)), cwd=cwd, env=variables, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def distributions(tmp_path_factory) -> dict[str, Path]:
    """Build sdist and wheel from the repository, the wheel out of the sdist."""
    work = tmp_path_factory.mktemp("build")
    venv.create(work / "environment", with_pip=True)
    python = work / "environment" / "bin" / "python"
    run(python, "-m", "pip", "install", "--quiet", "hatchling", cwd=work)
    run(python, "-m", "hatchling", "build", "-t", "sdist", "-d", work / "dist", cwd=ROOT)
    (sdist,) = (work / "dist").glob("*.tar.gz")
    command = [python, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", work / "dist", sdist]
    run(*command, cwd=work)
    (wheel,) = (work / "dist").glob("*.whl")
    return {"sdist": sdist, "wheel": wheel}


def test_wheel_holds_the_package_alone(distributions):
    name = f"adaptive_fairing-{program_version()}"
    assert distributions["wheel"].name == f"{name}-py3-none-any.whl"
    with zipfile.ZipFile(distributions["wheel"]) as archive:
        names = set(archive.namelist())
    metadata = {entry for entry in names if entry.startswith(f"{name}.dist-info/")}
    files = [path for path in (ROOT / "adaptive_fairing").rglob("*") if path.suffix in PACKAGED]
    assert names - metadata == {path.relative_to(ROOT).as_posix() for path in files}


def test_sdist_holds_what_builds_and_tests_need(distributions):
    with tarfile.open(distributions["sdist"]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "blender_manifest.toml", "__init__.py", "README.md"} <= names
    assert {"LICENSE", "tests/conftest.py", "tools/build_extension.py"} <= names
    assert not {name for name in names if name.endswith((".whl", ".zip", ".pyc"))}
    assert not {name for name in names if name.startswith("research/")}


def test_installed_from_the_wheel_it_does_the_main_job(distributions, tmp_path):
    """With everything that pip resolves for this Python and the extra "blender"."""
    venv.create(tmp_path / "environment", with_pip=True)
    python = tmp_path / "environment" / "bin" / "python"
    package = f"{distributions['wheel']}[blender]"
    run(python, "-m", "pip", "install", "--quiet", package, cwd=tmp_path)
    run(python, "-m", "pip", "check", cwd=tmp_path)
    program = python.with_name("adaptive-fairing")
    assert program_version() in run(program, "--version", cwd=tmp_path)
    (tmp_path / "octahedron.obj").write_text(OCTAHEDRON)
    options = ["-o", "faired.blend", "--steps", "2"]
    run(program, "fair", "octahedron.obj", *options, cwd=tmp_path)
    count = (
        "import bpy; bpy.ops.wm.open_mainfile(filepath='faired.blend');"
        "print([len(mesh.shape_keys.key_blocks) for mesh in bpy.data.meshes if mesh.shape_keys])"
    )
    assert run(python, "-c", count, cwd=tmp_path).splitlines()[-1] == "[3]"


def test_the_core_installs_and_works_without_blender(distributions, tmp_path):
    """Without an extra pip brings numpy and scipy: what a script without Blender needs."""
    venv.create(tmp_path / "environment", with_pip=True)
    python = tmp_path / "environment" / "bin" / "python"
    own = {"pip", "setuptools"}  # of the empty environment
    run(python, "-m", "pip", "install", "--quiet", distributions["sdist"], cwd=tmp_path)
    installed = run(python, "-m", "pip", "list", "--format=freeze", cwd=tmp_path).split()
    names = {line.partition("==")[0] for line in installed} - own
    assert names == {"adaptive-fairing", "numpy", "scipy"}
    script = f"""
import importlib.util, numpy
from adaptive_fairing.core import FairingSettings, fair
assert importlib.util.find_spec("bpy") is None
vertices = numpy.array({VERTICES})
result = fair(vertices, numpy.array({TRIANGLES}), FairingSettings(steps=1))
print(result.stop_reason, numpy.isfinite(result.positions).all())
"""
    assert run(python, "-c", script, cwd=tmp_path).split() == ["steps", "True"]
    (tmp_path / "octahedron.obj").write_text(OCTAHEDRON)
    command = [python.with_name("adaptive-fairing"), "denoise", "octahedron.obj"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True)
    assert done.returncode == 1
    assert b"pip install bpy" in done.stderr
