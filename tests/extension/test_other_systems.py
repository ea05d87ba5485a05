"""Windows and macOS as far as Linux can tell: tags, names, paths, modules, encodings."""

from __future__ import annotations

import ast
import subprocess
import sys
import zipfile
from email.parser import BytesParser
from pathlib import Path, PureWindowsPath

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.tags import Tag, cpython_tags, mac_platforms
from packaging.utils import parse_wheel_filename

import build_extension
import fetch_wheels

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "adaptive_fairing"
SOURCES = sorted(PACKAGE.rglob("*.py"))
FOLDERS = (
    "adaptive_fairing",
    "assets",
    "benchmarks",
    "docs",
    "examples",
    "research",
    "tests",
    "tools",
)

# Platform tags that Blender's systems accept: the oldest system that README promises.
SYSTEMS = {
    "windows-x64": ["win_amd64"],
    "windows-arm64": ["win_arm64"],
    "macos-arm64": list(mac_platforms((12, 0), "arm64")),
    "macos-x64": list(mac_platforms((12, 0), "x86_64")),
    "linux-x64": ["manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64"],
}
# Python -> numpy of the official Blenders with it.
PYTHONS = {(3, 11): ("1.24.3", "1.26.4"), (3, 13): ("2.2.6",)}
RESERVED = {"con", "prn", "aux", "nul", *(f"{n}{i}" for n in ("com", "lpt") for i in range(1, 10))}
INSTALLED = PureWindowsPath(
    r"C:\Users\twenty-characters-xx\AppData\Roaming\Blender Foundation\Blender\5.2\extensions"
)
MAX_PATH = 260
"""Characters of a path that Windows takes by default, with the zero at the end."""


def wheel_for(system: str, python: tuple[int, int]) -> fetch_wheels.Wheel:
    """Return the wheel that Blender's installer takes there."""
    accepted = set(cpython_tags(python, platforms=SYSTEMS[system]))
    (wheel,) = (
        wheel
        for wheel in fetch_wheels.WHEELS[system]
        if accepted & parse_wheel_filename(wheel.filename)[3]
    )
    return wheel


@pytest.mark.parametrize("python", PYTHONS, ids="{0[0]}.{0[1]}".format)
@pytest.mark.parametrize("system", SYSTEMS)
def test_every_system_has_one_wheel_for_each_python(system, python):
    assert wheel_for(system, python).abi == "cp" + "".join(map(str, python))


@pytest.mark.thorough
@pytest.mark.parametrize("python", PYTHONS, ids="{0[0]}.{0[1]}".format)
@pytest.mark.parametrize("system", SYSTEMS)
def test_a_wheel_says_inside_what_its_name_says_and_takes_blenders_numpy(system, python):
    wheel = wheel_for(system, python)
    with zipfile.ZipFile(fetch_wheels.fetch(wheel, fetch_wheels.DEFAULT_DIRECTORY)) as archive:
        names = archive.namelist()
        folder = next(name.split("/")[0] for name in names if name.endswith(".dist-info/WHEEL"))
        inside = BytesParser().parsebytes(archive.read(f"{folder}/WHEEL"))
        metadata = BytesParser().parsebytes(archive.read(f"{folder}/METADATA"))
    tags = {Tag(*text.split("-")) for text in inside.get_all("Tag")}
    assert tags == set(parse_wheel_filename(wheel.filename)[3])
    assert SpecifierSet(metadata["Requires-Python"]).contains("{}.{}.0".format(*python))
    required = [Requirement(text) for text in metadata.get_all("Requires-Dist")]
    (numpy,) = (each for each in required if each.name == "numpy" and each.marker is None)
    newest = PYTHONS[python] if system != "windows-arm64" else PYTHONS[python][-1:]
    for version in newest:
        assert numpy.specifier.contains(version), (wheel.filename, version)
    if system.startswith("windows"):
        place = INSTALLED / ".local" / "lib" / "python3.13" / "site-packages"
        assert max(len(str(place / name)) for name in names) < MAX_PATH


def test_no_two_files_differ_in_case_only_and_no_name_is_reserved():
    seen: dict[str, Path] = {}
    for path in (found for folder in FOLDERS for found in (ROOT / folder).rglob("*")):
        relative = path.relative_to(ROOT)
        other = seen.setdefault(str(relative).casefold(), relative)
        assert other == relative
        assert path.name.split(".")[0].casefold() not in RESERVED
        assert not set('<>:"|?*\\') & set(path.name)
        assert path.name == path.name.rstrip(" .")


def test_the_extension_fits_into_a_path_of_windows():
    place = INSTALLED / "user_default" / "adaptive_fairing"
    longest = max(len(str(place / path.relative_to(ROOT))) for path in SOURCES)
    compiled = len(r"\__pycache__") + len(".cpython-313")
    assert longest + compiled < MAX_PATH


def test_text_files_name_their_encoding():
    """That of Windows is not UTF-8 by default. What Linux says of its memory is ASCII."""
    for path in SOURCES:
        text = path.read_text("utf-8")
        for call in [] if '"/proc/' in text else ast.walk(ast.parse(text)):
            if not isinstance(call, ast.Call):
                continue
            name = getattr(call.func, "attr", getattr(call.func, "id", ""))
            if name not in ("open", "read_text", "write_text", "NamedTemporaryFile", "fdopen"):
                continue
            values = [each.value for each in call.args if isinstance(each, ast.Constant)]
            is_binary = any(isinstance(value, str) and "b" in value for value in values)
            is_system_call = isinstance(call.func, ast.Attribute) and ast.unparse(
                call.func.value
            ) in ("os", "zipfile", "gzip")
            names_it = "encoding" in {each.arg for each in call.keywords} or "utf-8" in values
            is_nowhere = "os.devnull" in ast.unparse(call)
            assert is_binary or is_system_call or names_it or is_nowhere, (
                f"{path.relative_to(ROOT)}:{call.lineno}"
            )


def test_processes_are_started_anew_and_never_forked():
    """Windows has no fork, and macOS forks no program that has threads."""
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Attribute):
                assert node.attr not in ("fork", "forkpty"), path
            if isinstance(node, ast.keyword):
                assert node.arg not in ("preexec_fn", "pass_fds"), path
            if isinstance(node, ast.Import | ast.ImportFrom):
                names = [getattr(node, "module", None), *(each.name for each in node.names)]
                assert "multiprocessing" not in names, path


def test_it_imports_without_the_modules_that_windows_lacks():
    """Every module but Blender's, in a fresh process where those modules cannot be imported."""
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for path in SOURCES
        if "blender" not in path.parts and path.name != "__main__.py"
    ]
    program = (
        "import importlib, subprocess, sys, numpy, scipy.sparse.linalg, scipy.spatial\n"
        "for name in ('fcntl', 'grp', 'pwd', 'resource', 'termios', 'tty', 'syslog'):\n"
        "    sys.modules[name] = None\n"
        f"for name in {modules!r}:\n"
        "    importlib.import_module(name)\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=True, timeout=110)


def test_a_manifest_with_the_line_ends_of_windows_stays_valid(tmp_path, monkeypatch):
    for name in build_extension.CONTENTS:
        if name != build_extension.MANIFEST:
            (tmp_path / name).symlink_to(ROOT / name)
    text = (ROOT / build_extension.MANIFEST).read_bytes().replace(b"\n", b"\r\n")
    (tmp_path / build_extension.MANIFEST).write_bytes(text)
    monkeypatch.setattr(build_extension, "ROOT", tmp_path)
    (built,) = build_extension.build(
        [build_extension.NO_WHEELS], tmp_path / "out", wheels=Path("unused")
    )
    with zipfile.ZipFile(built) as archive:
        assert b"\r\n" in archive.read(build_extension.MANIFEST)
