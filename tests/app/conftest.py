"""A real Blender with the extension installed in it as a user would, for tests/app.

The first test of a session sets the program up if it is not there yet, see tools/real_blender.py.
Pictures and results stay in the directory that the environment variable APP_ARTEFACTS names, or
in pytest's temporary directory.
"""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
INSIDE = Path(__file__).resolve().parent / "inside"
SCREEN = (1600, 1000)
BUILDER = ["python3", str(ROOT / "tools/build_extension.py"), "no-wheels"]

sys.path.insert(0, str(ROOT / "tools"))

import debian_chroot  # noqa: E402  scripts of the project, not packages
import real_blender  # noqa: E402


class App:
    """The program, the user directory with the extension in it, and a place for artefacts."""

    def __init__(self, chroot: debian_chroot.Chroot, directory: Path) -> None:
        self.chroot = chroot
        self.directory = directory
        self.resources = directory / "resources"
        self.resources.mkdir(exist_ok=True)
        self._played: dict[str, dict | AssertionError] = {}

    def shell(self, *command: str, timeout: float = 300) -> int:
        """Run a command beside Blender, offline; its exit code."""
        return debian_chroot.run_inside(
            self.chroot,
            shlex.join(command),
            binds=[self.directory],
            environment=self._environment,
            timeout=timeout,
        )

    def blender(
        self,
        arguments: Sequence[str | Path],
        *,
        screen: tuple[int, int] | None = None,
        timeout: float = 300,
    ) -> int:
        """Run Blender with the user directory; its exit code."""
        return debian_chroot.run_inside(
            self.chroot,
            real_blender.blender_script([str(each) for each in arguments], screen=screen),
            binds=[self.directory],
            environment=self._environment,
            timeout=timeout,
        )

    def play(self, scenario: str) -> dict:
        """Play a scenario of inside/*_scenarios.py in a window; once a session, even if it fails.

        Returns
        -------
        dict
            What the scenario has seen.
        """
        if scenario not in self._played:
            try:
                self._played[scenario] = self._play(scenario)
            except AssertionError as failure:
                self._played[scenario] = failure
        outcome = self._played[scenario]
        if isinstance(outcome, AssertionError):
            raise outcome
        return outcome

    def _play(self, scenario: str) -> dict:
        stage = self.directory / scenario
        stage.mkdir(exist_ok=True)
        script = ["--python", INSIDE / "scenarios.py", "--", scenario, stage]
        code = self.blender(script, screen=SCREEN, timeout=600)
        result = stage / "result.json"
        assert result.exists(), f"Blender ended with {code} in the middle of {scenario}"
        results = json.loads(result.read_text())
        assert "error" not in results, f"{results['error']}\npictures in {stage}"
        assert code == 0, f"Blender ended with {code} after {scenario}"
        return results

    def script(self, *arguments: object) -> dict:
        """Run inside/background.py without a window; the last argument is the result's folder."""
        run = ["-b", "--python-exit-code", "9", "--python", INSIDE / "background.py", "--"]
        assert self.blender([*run, *arguments]) == 0, "inside/background.py failed, see the output"
        return json.loads((arguments[-1] / "result.json").read_text())

    @property
    def _environment(self) -> dict[str, str]:
        return {"BLENDER_USER_RESOURCES": str(self.resources)}


@pytest.fixture(scope="session")
def app(tmp_path_factory) -> App:
    """A Blender with the extension built, installed and enabled.

    It is 4.3.2 of Debian 13, or that of the Debian release named by the variable APP_SUITE.
    """
    chroot = debian_chroot.locate(os.environ.get("APP_SUITE", "trixie"))
    debian_chroot.set_up(chroot)
    named = os.environ.get("APP_ARTEFACTS")
    directory = Path(named).resolve() if named else tmp_path_factory.mktemp("app")
    directory.mkdir(parents=True, exist_ok=True)
    program = App(chroot, directory)
    build = [*BUILDER, "--blender", "/usr/bin/blender", "--output", str(directory)]
    assert program.shell(*build) == 0, "the extension could not be built"
    (package,) = directory.glob("adaptive_fairing-*.zip")
    install = ["--command", "extension", "install-file", "-r", "user_default", "--enable", package]
    assert program.blender(install) == 0, "the extension could not be installed"
    return program
