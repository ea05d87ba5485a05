"""Under-fairing of coarse parts and over-fairing of dense ones, by density class.

The noise that is left is the distance between the faired noisy mesh and the faired clean mesh; the
detail that is lost is the distance between the faired clean mesh and the clean mesh itself. A
scheme under-fairs where the first is large and over-fairs where the second is. The radius is that
of the smoothing, in local edge lengths, in the coarsest and the densest hundredth of the vertices.
"""

from __future__ import annotations

from collections.abc import Sequence

from adaptive_fairing.core.diffusion.smoothing_radius import radius_scale

from .measures import SCHEMES, Scheme, matched_tau
from .pairs import MeshPair
from .tables import Cell, Findings, Table

COLUMNS = (
    "scheme", "τ", "radius", "coarsest fifth", "2nd", "3rd", "4th", "densest fifth", "worst error",
)  # fmt: skip


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Measure all schemes at the paper's τ, and at equally smooth coarse parts."""
    return Findings([table for pair in pairs for table in _tables(pair)])


def _tables(pair: MeshPair) -> list[Table]:
    steps = pair.published.steps
    untouched = pair.classes.by_fifth(pair.noisy, pair.clean)
    noisy = ["input", None, None, *((noise, 0.0) for noise in untouched), max(untouched)]
    published = [noisy]
    matched = [noisy]
    for scheme in SCHEMES:
        published.append(_row(pair, scheme, pair.published.tau(scheme.method)))
        tau = matched_tau(scheme, pair.noisy, pair.clean, pair.classes, steps)
        matched.append(_row(pair, scheme, tau))
    what = f"noise left / detail lost, in local edge lengths, after {steps} steps"
    return [
        Table(f"{pair.name}, the paper's τ: {what}", COLUMNS, published),
        Table(f"{pair.name}, coarse parts equally smooth: {what}", COLUMNS, matched),
    ]


def _row(pair: MeshPair, scheme: Scheme, tau: float) -> list[Cell]:
    steps = pair.published.steps
    from_noisy = scheme.faired(pair.noisy, pair.triangles, tau, steps)
    from_clean = scheme.faired(pair.clean, pair.triangles, tau, steps)
    noise = pair.classes.by_fifth(from_noisy, from_clean)
    detail = pair.classes.by_fifth(from_clean, pair.clean)
    error = pair.classes.by_fifth(from_noisy, pair.clean)
    scale = radius_scale(pair.noisy, pair.triangles, scheme.settings(tau, steps))
    densest, _, coarsest = scale.radii(steps * tau)
    return [scheme.label, tau, (coarsest, densest), *zip(noise, detail, strict=True), max(error)]
