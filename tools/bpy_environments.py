"""Virtual environments with Blender's bpy module, one for each supported Blender.

Each has the numpy of that official Blender and no scipy, because official Blenders have none. They
are kept in a cache directory, about 1 GB each, and made when missing.

    python tools/bpy_environments.py

prints the versions, for scripts.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fetch_wheels import WHEELS

DEFAULT_CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"), "adaptive-fairing")
TEST_REQUIREMENTS = (
    "pytest>=8", "pytest-xdist>=3.6", "hypothesis>=6.100", "psutil>=5.9", "tqdm>=4.60",
)  # fmt: skip


@dataclass(frozen=True)
class BlenderModule:
    """A bpy wheel.

    Attributes
    ----------
    version, python
    numpy
        That of the official Blender.
    may_crash
        Whether the tests in it were seen to crash, once in many runs and never again there.
    """

    version: str
    python: str
    numpy: str
    may_crash: bool = False

    def has_numerics_of(self, other: BlenderModule) -> bool:
        """Whether the core, which needs no Blender, runs on the same Python and numpy."""
        return (self.python, self.numpy) == (other.python, other.numpy)


BLENDERS = (
    BlenderModule("4.2.23", "3.11", "numpy==1.24.3", may_crash=True),
    BlenderModule("4.5.15", "3.11", "numpy==1.26.4"),
    BlenderModule("5.0.1", "3.11", "numpy==1.26.4"),
    BlenderModule("5.2.3", "3.13", "numpy>=2.2,<2.7"),
)


class PythonNotFoundError(Exception):
    """The Python that a Blender needs is not on this machine; the message says which."""


class InstallError(Exception):
    """pip could not install what was asked for; the message has its output."""


def find_python(version: str) -> Path:
    """Return an interpreter of `version`, such as "3.11", that starts.

    It is looked for in this process, on the PATH and among pyenv's versions: a shim of pyenv on
    the PATH is there even when the version it stands for is not selected.

    Raises
    ------
    PythonNotFoundError
        If there is none.
    """
    for candidate in _python_candidates(version):
        probe = [str(candidate), "-c", "import sys, venv; print('%d.%d' % sys.version_info[:2])"]
        done = subprocess.run(probe, capture_output=True, text=True, check=False)
        if done.returncode == 0 and done.stdout.strip() == version:
            return candidate
    raise PythonNotFoundError(f"no Python {version} on this machine")


def make_environment(module: BlenderModule, cache: Path) -> Path:
    """Return the Python of the environment of `module`, which is made when missing.

    Raises
    ------
    PythonNotFoundError
        If its Python is not on this machine.
    InstallError
        If pip fails.
    """
    directory = cache / "blenders" / module.version
    python = directory / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    complete = directory / "complete"
    if not complete.exists():
        base = find_python(module.python)
        shutil.rmtree(directory, ignore_errors=True)
        subprocess.run([str(base), "-m", "venv", str(directory)], check=True)
        _pip_install(python, [f"bpy=={module.version}", module.numpy])
        complete.touch()
    return python


def make_test_packages(module: BlenderModule, cache: Path) -> Path:
    """Return a folder with pytest and scipy for `module`, to be put on the PYTHONPATH.

    It is apart from the environment, which stays as bare as the official Blender. scipy has the
    version that the extension carries for this Python.
    """
    directory = cache / "test-packages" / module.version
    complete = directory / "complete"
    abi = "cp" + module.python.replace(".", "")
    scipy = next(wheel for wheel in WHEELS["linux-x64"] if wheel.abi == abi)
    wanted = "\n".join([*TEST_REQUIREMENTS, scipy.requirement])
    # A folder of an earlier version may lack what the tests have come to need.
    if not complete.exists() or complete.read_text(encoding="utf-8") != wanted:
        python = make_environment(module, cache)
        shutil.rmtree(directory, ignore_errors=True)
        target = ["--target", str(directory)]
        _pip_install(python, [*target, *TEST_REQUIREMENTS])
        # Without its requirements: numpy has to be the environment's own.
        _pip_install(python, [*target, "--no-deps", scipy.requirement])
        complete.write_text(wanted, encoding="utf-8")
    return directory


def _python_candidates(version: str) -> Iterator[Path]:
    if "{}.{}".format(*sys.version_info) == version:
        yield Path(sys.executable)
    if on_path := shutil.which(f"python{version}"):
        yield Path(on_path)
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    yield from sorted(pyenv.glob(f"versions/{version}.*/bin/python"), reverse=True)


def _pip_install(python: Path, arguments: Sequence[str]) -> None:
    pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    done = subprocess.run([*pip, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise InstallError(f"pip install {' '.join(arguments)} failed\n{done.stderr.strip()}")


if __name__ == "__main__":
    print(*(module.version for module in BLENDERS))
