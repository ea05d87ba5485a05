"""Install the built extension in every supported Blender and print a table of what ran.

The Blenders are the bpy modules of the supported versions (tools/bpy_environments.py), and real
programs when some are named: a Blender on this machine, or one of a Debian release in a chroot
(tools/real_blender.py, needs root). In each of them tests/extension/check_installed.py runs in
fresh processes; under the bpy modules the fast tests run as well, but for those that have been run
there already. The core knows nothing of Blender, so its tests run once for each Python and numpy.
If a module that may crash does, its tests run once more, and the table is followed by where it
crashed.

Usage: python tools/compatibility_matrix.py [--only [VERSION ...]] [--blender COMMAND ...]
       [--debian RELEASE ...] [--cache DIR] [--tested [VERSION ...]]

The exit status is 1 if anything failed. A Blender whose Python is not on this machine has a row
that says so.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import build_extension
from bpy_environments import (
    BLENDERS,
    DEFAULT_CACHE,
    BlenderModule,
    InstallError,
    PythonNotFoundError,
    make_environment,
    make_test_packages,
)

ROOT = Path(__file__).resolve().parent.parent
CHECK = ROOT / "tests" / "extension" / "check_installed.py"
MODULE = "bl_ext.user_default.adaptive_fairing"
PATIENCE = 1800  # seconds for one process, so that one that hangs is a failure of its row alone
# Named as the checks are, apart from the last three.
COLUMNS = (
    "python", "numpy", "install", "first enable", "cold enable", "operator", "scipy origin",
    "command", "disable", "enable again", "example script", "uninstall", "same bytes",
    "without scipy", "tests",
)  # fmt: skip


@dataclass
class Row:
    """Results of one Blender: a short text per column, and every failure and crash in full."""

    name: str
    cells: dict[str, str] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    crashes: list[str] = field(default_factory=list)

    def fail(self, column: str, details: str) -> None:
        """Record a failure."""
        self.cells[column] = "FAILED"
        self.failures.append(f"{self.name}, {column}: {details.strip()}")


def run_isolated(
    command: Sequence[str], work: Path, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a command with a user directory of its own, ``work/user``.

    Nothing of the caller's PYTHONPATH gets through: it could stand in for what the extension
    should bring.
    """
    user = work / "user"
    user.mkdir(parents=True, exist_ok=True)
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    variables |= {"BLENDER_USER_RESOURCES": str(user), **environment}
    try:
        return subprocess.run(
            list(command),
            cwd=work,
            env=variables,
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
        )
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 124, "", f"still running after {PATIENCE} s")


def run_phase(start: Sequence[str], phase: str, work: Path, archive: Path | None = None) -> dict:
    """Run one phase of check_installed.py in a fresh process and return its result.

    Parameters
    ----------
    start
        The command up to the arguments of check_installed.py.
    phase
        Its name, see check_installed.py.
    work
        Folder of this Blender, for its user directory and the meshes.
    archive
        The zip, for the phases that install.
    """
    result = work / f"{phase}.json"
    result.unlink(missing_ok=True)
    command = [*start, phase, "--work", str(work), "--result", str(result)]
    if archive is not None:
        command += ["--zip", str(archive)]
    done = run_isolated(command, work)
    if result.exists():
        return json.loads(result.read_text("utf-8"))
    error = f"exit status {done.returncode} and no result\n{done.stdout}{done.stderr}"
    return {"checks": {}, "failed": {"check": phase, "error": error}}


def check_blender(
    row: Row,
    start: Sequence[str],
    program: Sequence[str],
    work: Path,
    *,
    archive: Path,
    plain: Path,
    **environment: str,
) -> None:
    """Fill a row: install, use and uninstall; the same file from `program`; life without scipy.

    Parameters
    ----------
    row
        The row to fill.
    start
        The command up to the arguments of check_installed.py.
    program
        The command line program whose output must be the one of the command run inside Blender.
    work
        An empty folder.
    archive, plain
        The zip for this Blender, and the one without wheels.
    **environment
        Variables for `program`.
    """
    installed = run_phase(start, "install", work, archive)
    _take(row, installed)
    if installed["failed"] is None:
        # The program comes first: "use" ends with uninstalling, and with that goes the scipy.
        arguments = ["fair", str(work / "noisy.ply"), "-o", str(work / "program.ply")]
        arguments += ["--steps", "2"]
        done = run_isolated([*program, *arguments, "--quiet"], work, **environment)
        _take(row, run_phase(start, "use", work))
        written = [work / "program.ply", work / "command.ply"]
        if done.returncode != 0:
            row.fail("same bytes", f"exit status {done.returncode}\n{done.stdout}{done.stderr}")
        elif not all(path.exists() for path in written):
            row.fail("same bytes", "one of the two wrote no file")
        elif written[0].read_bytes() != written[1].read_bytes():
            row.fail("same bytes", "the program and the command in Blender differ")
        else:
            row.cells["same bytes"] = "yes"
    bare = run_phase(start, "without-scipy", work, plain)
    if bare["failed"] is None:
        row.cells["without scipy"] = "says so"
    else:
        row.fail("without scipy", f"{bare['failed']['check']}\n{bare['failed']['error']}")


def check_module(
    module: BlenderModule,
    archives: dict[str, Path],
    cache: Path,
    tested: Sequence[BlenderModule],
) -> Row:
    """Return the row of a bpy module; its tests run unless it is among those `tested` before."""
    row = Row(f"bpy {module.version}")
    try:
        python = make_environment(module, cache)
    except PythonNotFoundError as error:
        row.cells["python"] = f"not run: {error}"
        return row
    except InstallError as error:
        row.fail("python", str(error))
        return row
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch)
        packages = work / "user/extensions/.local/lib" / f"python{module.python}" / "site-packages"
        check_blender(
            row,
            [str(python), str(CHECK)],
            [str(python), "-m", "adaptive_fairing"],
            work,
            archive=archives["linux-x64"],
            plain=archives[build_extension.NO_WHEELS],
            PYTHONPATH=os.pathsep.join([str(ROOT), str(packages)]),
        )
        if module in tested:
            row.cells["tests"] = "run before"
        else:
            try:
                _run_tests(row, module, python, make_test_packages(module, cache), work, tested)
            except InstallError as error:
                row.fail("tests", str(error))
    return row


def check_program(name: str, command: Sequence[str], plain: Path, work: Path) -> Row:
    """Return the row of a real Blender; its scipy is its own, so the zip without wheels is used.

    Parameters
    ----------
    name
        What to call it while it has not told its version.
    command
        Starts this Blender.
    plain, work
        See `check_blender`.
    """
    row = Row(name)
    start = [*command, "-b", "--factory-startup", "--python", str(CHECK), "--"]
    program = [*command, "--factory-startup", "--addons", MODULE, "-c", "adaptive_fairing"]
    check_blender(row, start, program, work, archive=plain, plain=plain)
    return row


def check_debian(release: str, plain: Path) -> Row:
    """Return the row of the Blender of a Debian release, in a chroot made when missing."""
    with tempfile.TemporaryDirectory() as scratch:
        command = [sys.executable, str(ROOT / "tools" / "real_blender.py"), "--suite", release]
        command += ["run", "--bind", scratch, "--bind", str(plain.parent)]
        command += ["--env", f"BLENDER_USER_RESOURCES={scratch}/user", "--"]
        return check_program(f"Debian {release}", command, plain, Path(scratch))


def table(rows: Sequence[Row]) -> str:
    """Return the rows as a Markdown table."""
    lines = [("Blender", *COLUMNS)]
    lines += [(row.name, *(row.cells.get(name, "-") for name in COLUMNS)) for row in rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    lines.insert(1, tuple("-" * width for width in widths))
    padded = (map(str.ljust, line, widths) for line in lines)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in padded)


def _take(row: Row, result: dict) -> None:
    """Put a phase's result into the row."""
    row.cells |= result["checks"]
    if "blender" in result:
        if result["blender"].split()[0] not in row.name:
            row.name += f" (Blender {result['blender']})"
        row.cells |= {"python": result["python"], "numpy": result["numpy"]}
    if result["failed"] is not None:
        row.fail(result["failed"]["check"], result["failed"]["error"])


def _run_tests(
    row: Row,
    module: BlenderModule,
    python: Path,
    packages: Path,
    work: Path,
    tested: Sequence[BlenderModule],
) -> None:
    """Run the fast tests of core and add-on under a bpy module; keep pytest's summaries."""
    alike = [each.version for each in tested if each.has_numerics_of(module)]
    summaries = [f"core as in {alike[0]}"] if alike else []
    for folder in ("blender",) if alike else ("core", "blender"):
        command = [str(python), "-m", "pytest", "--quiet", "-p", "no:cacheprovider"]
        command += ["--rootdir", str(ROOT), "--config-file", str(ROOT / "pyproject.toml")]
        command.append(str(ROOT / "tests" / folder))
        done = run_isolated(command, work, PYTHONPATH=str(packages))
        if done.returncode < 0 and module.may_crash:
            row.crashes.append(f"{row.name}, tests/{folder}: {_ends(done)}")
            done = run_isolated(command, work, PYTHONPATH=str(packages))
        if done.returncode == 0:
            summaries.append(done.stdout.strip().splitlines()[-1].partition(" in ")[0])
        else:
            row.fail("tests", f"{folder}\n{_ends(done)}")
            return
    row.cells["tests"] = " + ".join(summaries)


def _ends(done: subprocess.CompletedProcess[str]) -> str:
    """Return the end of what a process said; of a crash that is where each thread was."""
    errors = re.sub(r"(?m)^Extension modules: .*$", "", done.stderr)
    return f"exit status {done.returncode}\n{done.stdout[-6000:]}\n{errors[-6000:]}"


def main(arguments: list[str] | None = None) -> int:
    """Build the zips, fill the rows, print the table and the failures."""
    versions = [module.version for module in BLENDERS]
    parser = argparse.ArgumentParser(description="Try the extension in every supported Blender.")
    parser.add_argument(
        "--only", nargs="*", default=versions, metavar="VERSION", help=f"out of {versions}"
    )
    parser.add_argument(
        "--blender", nargs="+", default=[], metavar="COMMAND", help="a Blender of this machine"
    )
    parser.add_argument(
        "--debian", nargs="+", default=[], metavar="RELEASE", help="the Blender of this Debian"
    )
    parser.add_argument("--cache", type=Path, default=DEFAULT_CACHE)
    parser.add_argument(
        "--tested", nargs="*", default=[], metavar="VERSION", help="where the tests have been run"
    )
    options = parser.parse_args(arguments)
    if unknown := {*options.only, *options.tested} - set(versions):
        parser.error(f"unknown version {', '.join(sorted(unknown))}; known: {', '.join(versions)}")

    rows: list[Row] = []

    def add(row: Row) -> None:
        rows.append(row)
        print(f"{row.name}: {'FAILED' if row.failures else 'done'}", file=sys.stderr)

    with tempfile.TemporaryDirectory() as scratch:
        archives = {
            name: build_extension.build([name], Path(scratch), wheels=options.cache / "wheels")[0]
            for name in (build_extension.NO_WHEELS, "linux-x64")
        }
        tested = [module for module in BLENDERS if module.version in options.tested]
        for module in BLENDERS:
            if module.version in options.only:
                row = check_module(module, archives, options.cache, tested)
                add(row)
                if row.cells.get("tests", "FAILED") != "FAILED":
                    tested.append(module)
        plain = archives[build_extension.NO_WHEELS]
        for command in options.blender:
            work = Path(tempfile.mkdtemp(dir=scratch))
            add(check_program(command, shlex.split(command), plain, work))
        for release in options.debian:
            add(check_debian(release, plain))
    print(table(rows))
    for crash in [crash for row in rows for crash in row.crashes]:
        print(f"\nCRASHED, and run once more: {crash}", file=sys.stderr)
    failures = [failure for row in rows for failure in row.failures]
    for failure in failures:
        print(f"\n{failure}", file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
