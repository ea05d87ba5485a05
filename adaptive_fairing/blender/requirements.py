"""Requirements on the Python that runs Blender, checked without importing them."""

from __future__ import annotations

from functools import cache
from importlib import metadata, util

SCIPY_MINIMUM = (1, 15)


@cache
def scipy_problem() -> str | None:
    """Message in one line: what is wrong with scipy and what to do; None if it can be used."""
    if util.find_spec("scipy") is None:
        return (
            "scipy is missing: install the package of this extension for your platform, "
            "or scipy in Blender's Python"
        )
    try:
        version = metadata.version("scipy")
    except metadata.PackageNotFoundError:
        return None  # importable without metadata, as some distributions ship it
    if _leading_numbers(version) < SCIPY_MINIMUM:
        needed = ".".join(map(str, SCIPY_MINIMUM))
        return (
            f"scipy {version} is too old, {needed} is needed: another extension may have "
            "brought it; update that extension, or scipy in Blender's Python"
        )
    return None


def _leading_numbers(version: str) -> tuple[int, ...]:
    """Major and minor number of a version."""
    return tuple(int(part) for part in version.split(".")[:2] if part.isdigit())
