"""Under-fairing of coarse parts and over-fairing of dense ones, by density class.

The noise that is left is the distance between the faired noisy mesh and the faired clean mesh; the
detail that is lost is the distance between the faired clean mesh and the clean mesh itself. A
scheme under-fairs where the first is large and over-fairs where the second is.
"""

from __future__ import annotations

from collections.abc import Sequence

from .findings import Findings
from .measures import SCHEMES, Scheme, matched_tau
from .pairs import MeshPair
from .tables import Cell, Table

COLUMNS = ("scheme", "τ", "coarsest fifth", "2nd", "3rd", "4th", "densest fifth", "worst error")


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Measure all schemes at the paper's τ, and at equally smooth coarse parts."""
    return Findings([table for pair in pairs for table in _tables(pair)])


def _tables(pair: MeshPair) -> list[Table]:
    steps = pair.published.steps
    untouched = pair.classes.by_fifth(pair.noisy, pair.clean)
    noisy = ["input", None, *((noise, 0.0) for noise in untouched), max(untouched)]
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
    return [scheme.label, tau, *zip(noise, detail, strict=True), max(error)]
