"""Evidence that roughness over several edges is noise and not detail, fitted and judged.

    python -m research.denoising.smooth_evidence

Fits the weights of `evidence_of_noise` by logistic regression to shapes with the smooth noise of
scanners, and to the same shapes clean and with 14 kinds of detail all over them.  Then counts what
the evidence tells, with those weights and with the ones in use, on shapes that were left out, and
on a kind of noise that was (structured light).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit
from tqdm import tqdm

from adaptive_fairing.core.denoising.noise.smooth_noise import measures_of_noise, smooth_noise
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.stage import Stage
from adaptive_fairing.core.problem.caller_mesh import CallerMesh
from adaptive_fairing.core.problem.prepared_mesh import PreparedMesh
from benchmarks.measuring import table
from tools.geometry.triangles import Faces, FloatArray

from .detail_alarms import DETAIL, with_detail
from .pairs import CLEAN, made

FITTED = (
    "head", "pawn", "lens", "hills", "coral", "two_lumps", "crocodile", "mountains", "molecule",
    "bracket", "gear", "steps", "engraved", "pebble",
)  # fmt: skip
LEFT_OUT = ("foot", "socket", "cushion", "gyroid", "pipes", "bracket_even", "crystal", "shelf")
NOISES = (
    "camera:2", "camera:1", "correlated-2:0.1", "correlated-2:0.2", "correlated-4:0.2",
    "correlated-4:0.3", "correlated-6:0.4",
)  # fmt: skip
OTHER_NOISES = ("light:1.5",)

RIDGE = 0.3
"""Of the squared weights, in standard deviations of the measures."""


class Example(NamedTuple):
    """A mesh, what its roughness measures, and whether there is enough of both to tell noise.

    `measures` is None where the roughness is not smooth.
    """

    name: str
    is_noise: bool
    measures: tuple[float, ...] | None
    is_enough: bool = True


def main() -> None:
    """Print the weights and the rates."""
    groups = {
        "shapes fitted to": [*clean(FITTED), *noisy(FITTED, NOISES)],
        "shapes left out": [*clean(LEFT_OUT), *noisy(LEFT_OUT, NOISES)],
        "structured light": list(noisy(LEFT_OUT, OTHER_NOISES)),
    }
    own = fitted_weights(groups["shapes fitted to"])
    used = np.array(PARAMETERS.evidence_weights)
    print("weights fitted:", np.round(own, 2), " in use:", used)
    rows = []
    for name, weights in (("fitted", own), ("in use", used)):
        for group, members in groups.items():
            told = [each for each in members if is_told(each, weights)]
            wrong = [each.name for each in told if not each.is_noise]
            n_noisy = sum(each.is_noise for each in members)
            rows.append((
                name, group, f"{len(told) - len(wrong)} of {n_noisy}",
                f"{len(wrong)} of {len(members) - n_noisy}", ", ".join(wrong),
            ))  # fmt: skip
    print(table(("weights", "", "noise told", "detail taken for noise", "which"), rows))


def noisy(names: Sequence[str], noises: Sequence[str]) -> Iterator[Example]:
    """Measure shapes with smooth noise."""
    for pair in tqdm(made(list(names), list(noises)), unit="mesh"):
        yield Example(f"{pair.name} {pair.noise}", True, *measured(pair.noisy, pair.faces))


def clean(names: Sequence[str]) -> Iterator[Example]:
    """Measure shapes as they are, and with every kind of detail."""
    for pair in tqdm(made(list(names), [CLEAN]), unit="shape"):
        yield Example(pair.name, False, *measured(pair.clean, pair.faces))
        for kind in DETAIL:
            detailed = with_detail(pair.name, kind)
            yield Example(f"{pair.name} {kind}", False, *measured(*detailed))


def measured(vertices: FloatArray, faces: Faces) -> tuple[tuple[float, ...] | None, bool]:
    """Return what `evidence_of_noise` is linear in, and whether it would count; see `Example`."""
    mesh = CallerMesh.checked(vertices, faces)
    prepared = PreparedMesh.of(mesh)
    surface, positions = prepared.surface, prepared.frame(mesh.points, "box").inward(mesh.points)
    stage = Stage(surface.topology, positions, surface.is_cut, lambda _: None)
    counted = stage.parts.is_counted
    found = smooth_noise(stage.noisy.in_unit(counted), counted)
    if not found.may_be_noise:
        return None, False
    measures = measures_of_noise(found.misfit, found.evenness, found.outliers, found.lean)
    return measures, found.may_be_told


def fitted_weights(some: Sequence[Example]) -> FloatArray:
    """Fit the weights of the measures, and the constant after them."""
    judged = [each for each in some if each.measures is not None]
    rows = np.array([(*each.measures, 1.0) for each in judged])
    is_noise = np.array([each.is_noise for each in judged], float)
    ridge = RIDGE * np.append(np.var(rows[:, :-1], axis=0), 0)

    def unlikelihood(weights: FloatArray) -> tuple[float, FloatArray]:
        odds = rows @ weights
        value = np.sum(np.logaddexp(0, odds) - is_noise * odds) + ridge @ np.square(weights)
        return value, rows.T @ (expit(odds) - is_noise) + 2 * ridge * weights

    return minimize(unlikelihood, np.zeros(rows.shape[1]), jac=True, method="BFGS").x


def is_told(example: Example, weights: FloatArray) -> bool:
    """Whether noise is told with weights, the constant last."""
    if example.measures is None or not example.is_enough:
        return False
    return bool(weights @ (*example.measures, 1.0) >= PARAMETERS.least_evidence)


if __name__ == "__main__":
    main()
