"""Checks of settings: each raises `SettingsError`, which names the field and what it may be."""

from __future__ import annotations

import math

from ..errors import SettingsError
from ..mesh.solver_mesh import FRAMES

# Vertices on the rim of an open mesh stay where they are, or move along with the natural boundary
# condition.
BOUNDARIES = ("fixed", "free")


def require_choice(settings: object, name: str, choices: tuple[str, ...]) -> None:
    """Require one of a few words."""
    value = getattr(settings, name)
    if value not in choices:
        raise SettingsError(f"{name} must be one of {', '.join(choices)}, not {value!r}")


def require_integer(settings: object, name: str, *, least: int) -> None:
    """Require a whole number of at least `least`."""
    value = getattr(settings, name)
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise SettingsError(f"{name} must be a whole number of at least {least}, not {value!r}")


def require_number(settings: object, name: str, *, above: float, below: float = math.inf) -> None:
    """Require a number between two bounds, which are left out."""
    value = getattr(settings, name)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not above < value < below:
        bound = f"greater than {above:g}" + (
            f" and less than {below:g}" if below < math.inf else ""
        )
        raise SettingsError(f"{name} must be a number {bound}, not {value!r}")


def require_frame(settings: object, name: str) -> None:
    """Require a frame of the solver: "box", "sphere" or False."""
    value = getattr(settings, name)
    if value is not False and value not in FRAMES:
        raise SettingsError(f"{name} must be one of {', '.join(FRAMES)} or False, not {value!r}")


def require_flag(settings: object, name: str) -> None:
    """Require True or False."""
    value = getattr(settings, name)
    if not isinstance(value, bool):
        raise SettingsError(f"{name} must be True or False, not {value!r}")
