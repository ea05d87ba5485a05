"""Download the scipy wheels that the extension's per-platform packages carry.

Official Blenders run on Python 3.11 (4.2 to 5.0) or 3.13 (5.1 and later) and bring numpy but not
scipy, so one package holds one wheel for each. The wheels are pinned by file name and SHA-256,
fetched with pip, and never committed.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DEFAULT_DIRECTORY = ROOT / "wheels"


@dataclass(frozen=True)
class Wheel:
    """One pinned wheel; name, version and tags are read off the file name."""

    filename: str
    sha256: str

    @property
    def requirement(self) -> str:
        """The exact requirement, such as ``scipy==1.15.3``."""
        name, version = self.filename.split("-")[:2]
        return f"{name}=={version}"

    @property
    def abi(self) -> str:
        """The ABI tag, such as ``cp311``."""
        return self.filename.removesuffix(".whl").split("-")[-2]

    @property
    def platform_tags(self) -> list[str]:
        """The platform tags, oldest first as in the file name."""
        return self.filename.removesuffix(".whl").split("-")[-1].split(".")


# Blender's platform name -> its wheels. The version follows from the numpy each Blender brings:
# - Python 3.11: Blender 4.2 has numpy 1.24, which scipy 1.15 is the last series to accept.
# - Python 3.13: Blender 5.1 and later have numpy 2.2 or newer; scipy 1.17 accepts 1.26.4 to 2.6.
# - Windows on Arm: Blender exists from 4.5 (numpy 1.26), scipy wheels from 1.16.
WHEELS: dict[str, tuple[Wheel, ...]] = {
    "linux-x64": (
        Wheel(
            "scipy-1.15.3-cp311-cp311-manylinux_2_17_x86_64.manylinux2014_x86_64.whl",
            "39cb9c62e471b1bb3750066ecc3a3f3052b37751c7c3dfd0fd7e48900ed52982",
        ),
        Wheel(
            "scipy-1.17.1-cp313-cp313-manylinux_2_27_x86_64.manylinux_2_28_x86_64.whl",
            "581b2264fc0aa555f3f435a5944da7504ea3a065d7029ad60e7c3d1ae09c5464",
        ),
    ),
    "windows-x64": (
        Wheel(
            "scipy-1.15.3-cp311-cp311-win_amd64.whl",
            "ae48a786a28412d744c62fd7816a4118ef97e5be0bee968ce8f0a2fba7acf3bb",
        ),
        Wheel(
            "scipy-1.17.1-cp313-cp313-win_amd64.whl",
            "37425bc9175607b0268f493d79a292c39f9d001a357bebb6b88fdfaff13f6448",
        ),
    ),
    "windows-arm64": (
        Wheel(
            "scipy-1.17.1-cp311-cp311-win_arm64.whl",
            "9ecb4efb1cd6e8c4afea0daa91a87fbddbce1b99d2895d151596716c0b2e859d",
        ),
        Wheel(
            "scipy-1.17.1-cp313-cp313-win_arm64.whl",
            "5cf36e801231b6a2059bf354720274b7558746f3b1a4efb43fcf557ccd484a87",
        ),
    ),
    "macos-arm64": (
        Wheel(
            "scipy-1.15.3-cp311-cp311-macosx_12_0_arm64.whl",
            "34716e281f181a02341ddeaad584205bd2fd3c242063bd3423d61ac259ca7eba",
        ),
        Wheel(
            "scipy-1.17.1-cp313-cp313-macosx_12_0_arm64.whl",
            "6fac755ca3d2c3edcb22f479fceaa241704111414831ddd3bc6056e18516892f",
        ),
    ),
    "macos-x64": (
        Wheel(
            "scipy-1.15.3-cp311-cp311-macosx_10_13_x86_64.whl",
            "993439ce220d25e3696d1b23b233dd010169b62f6456488567e830654ee37a6b",
        ),
        Wheel(
            "scipy-1.17.1-cp313-cp313-macosx_10_14_x86_64.whl",
            "5e3c5c011904115f88a39308379c17f91546f77c1667cea98739fe0fccea804c",
        ),
    ),
}


class WheelError(Exception):
    """A wheel could not be had, or is not the pinned one."""


def file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file in hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def fetch(wheel: Wheel, directory: Path) -> Path:
    """Return the path of `wheel` in `directory`, downloading it when it is not there yet.

    Raises
    ------
    WheelError
        If pip cannot download the wheel or the file's SHA-256 is not the pinned one.
    """
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / wheel.filename
    if not path.exists():
        # Apart at first: another process that looks for the wheel never sees half of it.
        with tempfile.TemporaryDirectory(dir=directory) as apart:
            _download(wheel, Path(apart))
            downloaded = Path(apart, wheel.filename)
            if not downloaded.exists():
                raise WheelError(f"pip downloaded another file than {wheel.filename}")
            downloaded.replace(path)
    if (found := file_sha256(path)) != wheel.sha256:
        raise WheelError(f"{path}: SHA-256 is {found}, pinned is {wheel.sha256}; delete the file")
    return path


def fetch_platform(platform: str, directory: Path = DEFAULT_DIRECTORY) -> list[Path]:
    """Return the wheels of one of Blender's platforms, in the order of `WHEELS`."""
    return [fetch(wheel, directory) for wheel in WHEELS[platform]]


def _download(wheel: Wheel, directory: Path) -> None:
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
    command += ["--only-binary", ":all:", "--implementation", "cp", "--abi", wheel.abi]
    command += ["--python-version", wheel.abi.removeprefix("cp"), "--dest", str(directory)]
    for tag in wheel.platform_tags:
        command += ["--platform", tag]
    with tempfile.TemporaryDirectory() as scratch:
        requirements = Path(scratch, "requirements.txt")
        requirements.write_text(f"{wheel.requirement} --hash=sha256:{wheel.sha256}\n")
        command += ["--require-hashes", "--requirement", str(requirements)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise WheelError(f"{wheel.filename}: pip download failed\n{done.stderr.strip()}")
