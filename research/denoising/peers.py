"""The smoothers people use, each over a grid of parameters.

A peer runs along its *sweep*, from weak to strong, once for each of its *variants*; what iterates
goes on from its last result. Where the best parameter is the last of a sweep, the grid was too
narrow, which the tables say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import version

import numpy as np

from benchmarks.competitors import solved_by_cg
from tools.geometry.triangles import Faces, FloatArray, edges_of

from . import blender_modifiers
from .l0_minimisation import l0_minimisation
from .normal_filters import bilateral_filter, guided_filter

ITERATIONS = (
    1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 17, 20, 24, 29, 35, 42, 50, 60, 72, 86, 103, 124, 149, 179,
    215,
)  # fmt: skip
"""About a fifth more from one to the next: where errors are flat, at their least."""

Values = tuple[float, ...]

Results = Iterator[FloatArray]
"""Positions (n, 3) for every value of the sweep, in order."""


@dataclass(frozen=True)
class Peer:
    """A smoother and its grid.

    Attributes
    ----------
    name
        For the tables.
    packages
        What its results depend on: installed packages.
    sweep_name, sweep
        The parameter that says how strongly it smooths, and its values in rising order.
    run
        Called with positions (n, 3), triangles (m, 3), the sweep's values and a variant's options.
    variants
        The other parameters' values, by what they are called in the tables.
    starts_at_least
        The first value of the sweep is the least there is, such as one iteration.
    goes_on
        Every result is made from the one before, so that its time is that of all together.
    published
        The parameter that the authors give, for methods of the research literature.
    """

    name: str
    packages: tuple[str, ...]
    sweep_name: str
    sweep: Values
    run: Callable[..., Results]
    variants: Mapping[str, Mapping[str, float | str | bool]] = field(
        default_factory=lambda: {"": {}}
    )
    starts_at_least: bool = True
    goes_on: bool = True
    published: str | None = None

    @property
    def version(self) -> str:
        """Versions of all that computes."""
        return " ".join(f"{package} {version(package)}" for package in self.packages)

    def parameter(self, variant: str, value: float) -> str:
        """Name a point of the grid."""
        return f"{self.sweep_name} {value:g}" + (f", {variant}" if variant else "")

    def result(self, vertices: FloatArray, faces: Faces, parameter: str) -> FloatArray:
        """Return the positions at one point of the grid."""
        variant, k = self._point(parameter)
        sweep = self.sweep[: k + 1]
        *_, positions = self.run(vertices, faces, sweep, **self.variants[variant])
        return positions

    @property
    def as_published(self) -> Peer:
        """The peer at the parameter of its authors alone; without one, the whole grid."""
        if self.published is None:
            return self
        variant, k = self._point(self.published)
        return replace(self, sweep=(self.sweep[k],), variants={variant: self.variants[variant]})

    def _point(self, parameter: str) -> tuple[str, int]:
        """Return the variant of a point of the grid, and its place in the sweep."""
        for variant in self.variants:
            for k, value in enumerate(self.sweep):
                if self.parameter(variant, value) == parameter:
                    return variant, k
        raise KeyError(f"{self.name} has no {parameter}")

    def at_edge(self, parameter: str) -> bool:
        """Tell whether the grid should have gone further at this point of it."""
        if len(self.sweep) == 1:
            return False
        ends = self.sweep[-1:] if self.starts_at_least else (self.sweep[0], self.sweep[-1])
        return any(parameter == self.parameter(v, end) for v in self.variants for end in ends)


def meshlab(
    vertices: FloatArray,
    faces: Faces,
    sweep: Values,
    filter_name: str,
    counted: bool = True,
    **options,
) -> Results:
    """Repeat one step of a filter of MeshLab, as its own count of steps does."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    if counted:
        options["stepsmoothnum"] = 1
    done = 0
    for value in sweep:
        for _ in range(int(value) - done):
            meshes.apply_filter(filter_name, **options)
        done = int(value)
        yield meshes.current_mesh().vertex_matrix().copy()


def windowed_sinc(vertices: FloatArray, faces: Faces, sweep: Values, iterations: int) -> Results:
    """VTK's windowed sinc filter; the sweep is its pass band, where 2 lets everything through."""
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
    for value in sweep:
        smooth = mesh.smooth_taubin(
            n_iter=iterations, pass_band=1 / value, normalize_coordinates=True
        )
        yield np.array(smooth.points, dtype=float)


def cotangent_flow(vertices: FloatArray, faces: Faces, sweep: Values, steps: int) -> Results:
    """Implicit mean curvature flow with libigl's matrices, one diffusion time everywhere.

    The sweep is the smoothing radius √(2 t) of all steps together, in mean edges.
    """
    import igl

    faces = faces.astype(np.int64)
    ends = vertices[edges_of(faces)]
    edge = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean()
    laplacian = igl.cotmatrix(vertices, faces)
    for value in sweep:
        time = 0.5 * (value * edge) ** 2 / steps
        positions = vertices
        for _ in range(steps):
            mass = igl.massmatrix(positions, faces)
            matrix = (mass - time * laplacian).tocsr()
            positions = solved_by_cg(matrix, mass @ positions, positions, tolerance=1e-8)
        yield positions


def spread(first: float, last: float, count: int) -> Values:
    """Return values in even ratios, rounded to three digits."""
    return tuple(float(f"{value:.3g}") for value in np.geomspace(first, last, count))


def meshlab_peer(
    name: str, sweep: Values, variants: Mapping[str, dict], filter_name: str, **options: bool
) -> Peer:
    """Return a filter of MeshLab as a peer, by the variants of its other parameters."""
    named = {key: {"filter_name": filter_name, **each, **options} for key, each in variants.items()}
    return Peer(name, ("pymeshlab",), "iterations", sweep, meshlab, named)


ONE_STEP = {"starts_at_least": False, "goes_on": False}
"""For peers whose sweep is no count of iterations."""

IN_USE: Sequence[Peer] = (
    meshlab_peer(
        "MeshLab Laplacian",
        ITERATIONS[:20],
        {
            f"{weights} weights": {"cotangentweight": weights == "cotangent"}
            for weights in ("uniform", "cotangent")
        },
        "apply_coord_laplacian_smoothing",
    ),
    meshlab_peer(
        "MeshLab Taubin",
        ITERATIONS,
        {
            f"λ {forth:g}, μ {back:g}": {"lambda_": forth, "mu": back}
            for forth, back in ((0.5, -0.53), (0.33, -0.34), (0.5, -0.6))
        },
        "apply_coord_taubin_smoothing",
    ),
    meshlab_peer(
        "MeshLab HC", ITERATIONS, {"": {}}, "apply_coord_hc_laplacian_smoothing", counted=False
    ),
    meshlab_peer(
        "MeshLab two-step",
        ITERATIONS[:22],
        {
            f"normals within {angle:g}°, {normal_steps} + {fit_steps} inner": {
                "normalthr": float(angle),
                "stepnormalnum": normal_steps,
                "stepfitnum": fit_steps,
            }
            for angle in (30, 60)
            for normal_steps, fit_steps in ((20, 20), (2, 3), (1, 2), (1, 1))
        },
        "apply_coord_two_steps_smoothing",
    ),
    Peer(
        "VTK windowed sinc",
        ("vtk",),
        "1 / pass band",
        spread(0.6, 2000, 32),
        windowed_sinc,
        {f"{count} iterations": {"iterations": count} for count in (10, 15, 20, 30, 50, 100)},
        **ONE_STEP,
    ),
    Peer(
        "cotangent flow (libigl)",
        ("libigl", "scipy"),
        "radius",
        spread(0.03, 8, 29),
        cotangent_flow,
        {"1 step": {"steps": 1}, "4 steps": {"steps": 4}},
        **ONE_STEP,
    ),
    Peer("Blender Smooth", ("bpy",), "iterations", ITERATIONS[:20], blender_modifiers.smooth),
    Peer(
        "Blender Laplacian Smooth",
        ("bpy",),
        "λ",
        spread(0.003, 30, 24),
        blender_modifiers.laplacian_smooth,
        {f"{count} iterations": {"iterations": count} for count in (1, 4)},
        **ONE_STEP,
    ),
    Peer(
        "Blender Corrective Smooth",
        ("bpy",),
        "iterations",
        ITERATIONS[:20],
        blender_modifiers.corrective_smooth,
        {"simple": {"weights": "SIMPLE"}, "length weighted": {"weights": "LENGTH_WEIGHTED"}},
    ),
)
"""Methods in common use; parameters that are not named have the program's defaults."""

SIGMAS = {f"σ {sigma:g}": {"sigma": sigma} for sigma in (0.2, 0.35, 0.5)}

RESEARCH: Sequence[Peer] = (
    Peer(
        "bilateral normals",
        ("scipy",),
        "iterations",
        (2, 5, 10, 20, 40, 80),
        bilateral_filter,
        SIGMAS,
        starts_at_least=False,
        published="iterations 20, σ 0.35",
    ),
    Peer(
        "guided normals",
        ("scipy",),
        "iterations",
        (2, 5, 10, 20, 40, 75),
        guided_filter,
        SIGMAS,
        starts_at_least=False,
        published="iterations 20, σ 0.35",
    ),
    Peer(
        "L0 minimisation",
        ("scipy",),
        "λ",
        (0.05, 0.1, 0.2, 0.4, 0.8),
        l0_minimisation,
        starts_at_least=False,
        goes_on=False,
        published="λ 0.2",
    ),
)
"""What the research literature compares with, at the values that its authors give and around; L0
minimisation at the λ with which Zhang et al. compared their filter."""

PEERS: Sequence[Peer] = (*IN_USE, *RESEARCH)
