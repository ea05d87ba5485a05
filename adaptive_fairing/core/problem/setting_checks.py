"""Checks of settings: each raises `SettingsError`, which names the field and its valid values."""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import TypeVar

import numpy as np

from ..errors import SettingsError
from ..mesh.solver_mesh import FRAMES

# Boundary vertices of an open mesh stay where they are, or move along with the natural boundary
# condition.
BOUNDARIES = ("fixed", "free")


Settings = TypeVar("Settings")


def checked_settings(settings: object | None, kind: type[Settings]) -> Settings:
    """Check the type of the settings of an algorithm; None stands for the default settings."""
    if settings is None:
        return kind()
    if not isinstance(settings, kind):
        raise SettingsError(f"settings must be {kind.__name__}(…), not {settings!r:.60}")
    return settings


def require_choice(settings: object, name: str, choices: tuple[str, ...]) -> None:
    """Require one of several words."""
    value = getattr(settings, name)
    if not (isinstance(value, str) and value in choices):
        raise SettingsError(f"{name} must be one of {', '.join(choices)}, not {value!r}")


def require_integer(settings: object, name: str, *, least: int, most: int | None = None) -> None:
    """Require a whole number from `least` to `most`, and store it as Python's int."""
    value = getattr(settings, name)
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not is_whole or value < least or (most is not None and value > most):
        bound = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise SettingsError(f"{name} must be a whole number {bound}, not {value!r}")
    object.__setattr__(settings, name, int(value))


def require_number(settings: object, name: str, *, above: float, below: float = math.inf) -> None:
    """Require a number strictly between two bounds, and store it as Python's float."""
    value = getattr(settings, name)
    is_number = isinstance(value, Real) and not isinstance(value, (bool, np.bool_))
    if not is_number or not above < value < below:
        bound = f"greater than {above:g}" + (
            f" and less than {below:g}" if below < math.inf else ""
        )
        raise SettingsError(f"{name} must be a number {bound}, not {value!r}")
    object.__setattr__(settings, name, float(value))


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
