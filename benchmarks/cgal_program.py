"""Compile the little program around CGAL's smooth_shape, where Debian's packages are there."""

from __future__ import annotations

import shutil
import subprocess
from functools import lru_cache
from pathlib import Path

SOURCE = Path(__file__).resolve().parent / "cgal" / "smooth_shape.cpp"

HEADERS = (
    Path("/usr/include/CGAL/Polygon_mesh_processing/smooth_shape.h"),
    Path("/usr/include/eigen3/Eigen/Sparse"),
    Path("/usr/include/mpfr.h"),
)

NEEDS = "needs g++ and Debian's packages libcgal-dev, libeigen3-dev, libgmp-dev and libmpfr-dev"


class NotInstalledError(Exception):
    """The compiler or the libraries are not on this machine."""


@lru_cache(maxsize=1)
def compiled(folder: Path) -> Path:
    """Compile the program into `folder`, with all optimization, and return its path.

    Raises
    ------
    NotInstalledError
        If something is missing or does not compile.
    """
    compiler = shutil.which("g++")
    if compiler is None or not all(header.is_file() for header in HEADERS):
        raise NotInstalledError(NEEDS)
    program = folder / "smooth_shape"
    command = [compiler, "-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-DCGAL_EIGEN3_ENABLED"]
    command += ["-I/usr/include/eigen3", str(SOURCE), "-o", str(program), "-lmpfr", "-lgmp"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise NotInstalledError(f"does not compile: {done.stderr.strip().splitlines()[-1]}")
    return program
