"""Settings of the automatic method, checked when they are made."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real

from ..errors import SettingsError
from ..problem.setting_checks import BOUNDARIES, require_choice, require_number

FEATURES = ("auto", "sharp", "smooth")
CLEAN = ("keep", "detail", "denoise")
LARGEST_STRENGTH = 100.0
WIDTHS = 1.0, 16.0


@dataclass(frozen=True)
class DenoiseSettings:
    """Settings of `denoise`: what it cannot estimate, because it is a matter of taste.

    Attributes
    ----------
    strength : float
        Factor of the estimated noise, above 0 and below 100.
    features : str
        "sharp" keeps creases wherever possible, "smooth" assumes that there are none, "auto"
        decides locally.
    boundary : str
        "fixed": boundary vertices stay exactly where they are; "free": they move with the surface.
    clean : str
        "keep": a mesh that looks clean or like a low-poly model comes back unchanged, and a note
        says why. "detail": so does a mesh whose roughness may be detail, such as one that looks
        like the smooth noise of a scanner; "keep" removes that. "denoise": all roughness is treated
        as noise.
    width : "auto" or float
        Width of the noise: the distance in edges, from 1 to 16, at which its correlation is 1 / e;
        about half the size of its bumps. White noise has 1. It may be told up to half too large,
        which is recognised, but not too small. Noise of a given width is removed even from a mesh
        that looks clean: `clean` is not used. "auto" finds noise up to four edges wide where it
        differs from shape.
    max_deviation : float, optional
        No vertex ends further than this length, in object units, from its input position.

    Raises
    ------
    SettingsError
        If a value is invalid; the message names the field.
    """

    strength: float = 1.0
    features: str = "auto"
    boundary: str = "fixed"
    clean: str = "keep"
    width: str | float = "auto"
    max_deviation: float | None = None

    def __post_init__(self) -> None:
        require_number(self, "strength", above=0, below=LARGEST_STRENGTH)
        require_choice(self, "features", FEATURES)
        require_choice(self, "boundary", BOUNDARIES)
        require_choice(self, "clean", CLEAN)
        self._require_width()
        if self.max_deviation is not None:
            require_number(self, "max_deviation", above=0)

    def _require_width(self) -> None:
        least, most = WIDTHS
        if self.width == "auto":
            return
        is_number = isinstance(self.width, Real) and not isinstance(self.width, bool)
        if not (is_number and least <= float(self.width) <= most):
            raise SettingsError(
                f'width must be "auto" or a number of edges from {least:g} to {most:g}, '
                f"not {self.width!r}"
            )
        object.__setattr__(self, "width", float(self.width))
