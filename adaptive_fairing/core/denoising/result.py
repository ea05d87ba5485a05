"""Result of `denoise`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..fem.differential_geometry import SurfaceMeasures
from ..linalg.conjugate_gradients import SolveReport
from ..runtime.arrays import FloatArray
from .plan import STRENGTHS, DenoisePlan
from .settings import DenoiseSettings


@dataclass(frozen=True)
class DenoiseResult:
    """The denoised mesh at several strengths, and the estimated noise.

    Attributes
    ----------
    strengths : (k,)
        Ascending factors of the estimated noise, including that of the settings.
    shapes : (k, n, 3)
        Positions for each strength. Held vertices have their input coordinates bit by bit.
    start : (n, 3)
        Positions of the input.
    noise : (n,)
        Standard deviation of the noise along the normals, in local edge lengths; 0 where none was
        found.
    noise_level : float
        Median of `noise` over the vertices where noise was found; 0 if there is none.
    noise_length : float
        The same in the units of the input.
    radius : float
        Smoothing radius in local edge lengths: that of the Gaussian filter that keeps the same
        fraction of white noise. 0 if nothing was done.
    sharp_part : float
        Fraction of the removed noise that filters removed which keep creases, 0 to 1.
    crease_part : float
        Fraction of the edges of the denoised mesh that are creases, 0 to 1.
    is_sharp : bool
        Whether creases were asked for; with features "auto", whether there are more creases than
        smooth meshes have.
    initial : SurfaceMeasures
        Curvature energy, area and volume of the input's limit surface. If weights of 0 hold most of
        the mesh, they cover only the part around the moving vertices, which has no volume.
    measures : tuple of SurfaceMeasures
        The same for each of `shapes`.
    solve : SolveReport
        Iterations of all linear solves together, and the worst residual.
    notes : tuple of str
        What is wrong with the input and how it was made solvable; and why nothing was changed, if
        so.
    other_readings : tuple of str
        Values of `DenoiseSettings.clean` that take the same roughness for something else:
        "denoise" where it was kept as a clean mesh's, "detail" where what was removed
        may be detail, both where a part of it was removed.
    settings : DenoiseSettings
    plan : DenoisePlan
        To treat other frames of this surface alike, or another part of it if it is of the whole.
    """

    strengths: FloatArray
    shapes: FloatArray
    start: FloatArray = field(repr=False)
    noise: FloatArray
    noise_level: float
    noise_length: float
    radius: float
    sharp_part: float
    crease_part: float
    is_sharp: bool
    initial: SurfaceMeasures
    measures: tuple[SurfaceMeasures, ...]
    solve: SolveReport
    notes: tuple[str, ...]
    other_readings: tuple[str, ...]
    settings: DenoiseSettings
    plan: DenoisePlan = field(repr=False, compare=False)

    @property
    def chosen(self) -> int:
        """Index of the chosen strength."""
        return STRENGTHS.index(1.0)

    @property
    def positions(self) -> FloatArray:
        """Positions (n, 3) at the chosen strength."""
        return self.shapes[self.chosen]

    @property
    def is_changed(self) -> bool:
        """Whether any vertex has moved; if not, `notes` says why."""
        return not np.array_equal(self.positions, self.start)

    def at(self, strength: float) -> FloatArray:
        """Positions (n, 3) at any strength from 0, the input, to the largest of `strengths`.

        They are linear between two strengths, and constant beyond the last.  A vertex that has not
        moved is exactly where it was.
        """
        knots = np.concatenate([[0.0], self.strengths])
        place = float(np.interp(strength, knots, np.arange(len(knots))))
        below = int(place)
        low = self.shapes[below - 1] if below else self.start
        if below == len(self.strengths):
            return low.copy()
        return low + (place - below) * (self.shapes[below] - low)
