"""One program's smoothing of one mesh, timed in a process of its own.

    python -m benchmarks.competitors PROGRAM MESH.ply --tau 0.01 --time 0.001 --patience 20

prints one line of JSON with seconds for "one" step from scratch and "four" of them (null where one
took longer than the patience), the processor time of all threads for the last of these runs, the
root mean square of the displacement ("moved"), and the process's memory in bytes "before" the
smoothing and at its "peak". speed.py starts it.

The clock of a run on a known mesh starts after another such run, on another part. `denoise` has no
steps: one and four are the same.

A step is one iteration of the program. What it does differs: ours, CGAL's and libigl's diffuse for
the same time; Blender's Laplacian Smooth solves a system as well; the others replace every vertex
by an average of its neighbours.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tools.geometry.triangles import FloatArray

from . import meshes
from .measuring import peak_memory, resident_memory

if TYPE_CHECKING:
    from adaptive_fairing.core import DenoiseResult, FairingStep

CG_TOLERANCE = 1e-6
"""Relative residual, as in our default settings."""


class Amount(NamedTuple):
    """Amount of smoothing in a step: our τ, and the diffusion time in the mesh's units."""

    tau: float
    time: float


class Timed(NamedTuple):
    """Seconds of one run, the positions after it, and a step's own seconds where known."""

    seconds: float
    positions: FloatArray
    step: float | None = None


Smoother = Callable[[int], Timed]
"""Takes the number of steps."""


def ours(
    mesh: meshes.Mesh,
    amount: Amount,
    *,
    denoises: bool = False,
    is_known: bool = False,
    part: float | None = None,
) -> Smoother:
    """Adaptive fairing: set-up, then steps; a step is the time between two results.

    Or `denoise`.  On a mesh that is known, and on a part of the vertices: another one each run.
    """
    from adaptive_fairing.core import FairingSettings, PreparedMesh, denoise, fair_steps

    options: dict[str, object] = {}
    places = count(0, len(mesh.vertices) // 3)

    def results(steps: int) -> Iterable[DenoiseResult | FairingStep]:
        if denoises:
            return [denoise(mesh.vertices, mesh.triangles, **options)]
        settings = FairingSettings(tau=amount.tau, steps=steps, cg_tolerance=CG_TOLERANCE)
        return fair_steps(mesh.vertices, mesh.triangles, settings, **options)

    def run(steps: int) -> Timed:
        if part is not None:
            options["weights"] = meshes.weights_around(mesh.vertices, next(places), part)
        times = []
        start = time.perf_counter()
        for result in results(steps):
            times.append(time.perf_counter() - start)
            positions = result.positions.copy()  # the result holds shapes of all strengths
        # The first interval has the set-up; the last has no system for a next step.
        whole = np.diff(times)[:-1]
        step = float(whole.mean()) if len(whole) else None
        return Timed(times[-1], positions, step)

    if is_known:
        options["prepared"] = PreparedMesh(mesh.vertices, mesh.triangles)
        run(1)
    return run


def ours_on_the_first_surface(mesh: meshes.Mesh, amount: Amount) -> Smoother:
    """All steps with the matrices of the first, as CGAL and libigl keep theirs."""
    from adaptive_fairing.core import FairingSettings, LoopSpace, TriangleTopology, mesh_density

    def run(steps: int) -> Timed:
        start = time.perf_counter()
        positions, settings = mesh.vertices, FairingSettings()
        topology = TriangleTopology(mesh.triangles, len(positions))
        density = mesh_density(topology, positions, settings.density, settings.density_passes)
        space = LoopSpace(topology, settings.quadrature_tolerance)
        mass = space.mass_matrix(positions, amount.tau * density)
        system = mass + space.stiffness_matrix(positions)
        for _ in range(steps):
            positions = solved_by_cg(system, mass @ positions, positions)
        return Timed(time.perf_counter() - start, positions)

    return run


def solved_by_cg(
    matrix, right_side: FloatArray, start: FloatArray, tolerance: float = CG_TOLERANCE
) -> FloatArray:
    """Solve with scipy's conjugate gradients, one coordinate after the other."""
    from scipy.sparse import diags_array
    from scipy.sparse.linalg import cg

    inverse = diags_array(1 / matrix.diagonal())
    columns = [
        cg(matrix, b, x, rtol=tolerance, M=inverse)[0]
        for b, x in zip(right_side.T.copy(), start.T.copy(), strict=True)
    ]
    return np.stack(columns, axis=1)


def libigl(mesh: meshes.Mesh, amount: Amount, cholesky: bool = False) -> Smoother:
    """Semi-implicit mean curvature flow as in libigl's tutorial: the Laplacian stays the first."""
    import igl

    triangles = mesh.triangles.astype(np.int64)

    def solved(matrix, right_side: FloatArray, start: FloatArray) -> FloatArray:
        if cholesky:
            none = np.empty((0, 3)), np.empty(0, dtype=np.int64)
            return igl.min_quad_with_fixed(matrix.tocsc(), -right_side, none[1], none[0])
        return solved_by_cg(matrix.tocsr(), right_side, start)

    def run(steps: int) -> Timed:
        start = time.perf_counter()
        positions = mesh.vertices
        laplacian = igl.cotmatrix(positions, triangles)
        for _ in range(steps):
            mass = igl.massmatrix(positions, triangles)
            right_side = mass @ positions
            positions = solved(mass - amount.time * laplacian, right_side, positions)
        return Timed(time.perf_counter() - start, positions)

    return run


def meshlab(mesh: meshes.Mesh, amount: Amount, name: str) -> Smoother:
    """Run a filter of pymeshlab with its defaults; a step of Taubin's is forth and back."""
    import pymeshlab

    def run(steps: int) -> Timed:
        collection = pymeshlab.MeshSet()
        collection.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.triangles))
        start = time.perf_counter()
        collection.apply_filter(name, stepsmoothnum=steps)
        seconds = time.perf_counter() - start
        return Timed(seconds, collection.current_mesh().vertex_matrix())

    return run


def blender(mesh: meshes.Mesh, amount: Amount, modifier: str, **options: object) -> Smoother:
    """Evaluate a modifier in Blender."""
    import bpy

    from tools.geometry.blender_meshes import add_modifier, evaluated, new_object

    item = new_object(mesh.vertices, mesh.triangles)
    bpy.context.view_layer.update()

    def run(steps: int) -> Timed:
        item.modifiers.clear()
        bpy.context.view_layer.update()
        start = time.perf_counter()
        add_modifier(item, modifier, iterations=steps, **options)
        bpy.context.evaluated_depsgraph_get()
        seconds = time.perf_counter() - start
        return Timed(seconds, evaluated(item)[0])

    return run


OURS = "Adaptive Fairing"
DENOISE = "Denoise"
AGAIN, PART, PRESS, SMALL_PRESS = "second run", "1 %", "1 %, mesh known", "0.1 %, mesh known"
KEPT = "Adaptive Fairing, first matrices"

_KINDS = {
    AGAIN: {"is_known": True},
    PART: {"part": 0.01},
    PRESS: {"is_known": True, "part": 0.01},
    SMALL_PRESS: {"is_known": True, "part": 0.001},
}


def _of_ours(name: str, **options: bool) -> dict[str, Callable[[meshes.Mesh, Amount], Smoother]]:
    """All kinds of runs of one of our algorithms, by name."""
    whole = {name: partial(ours, **options)}
    return whole | {f"{name}, {kind}": partial(ours, **options, **_KINDS[kind]) for kind in _KINDS}


OWN_RUNS = {**_of_ours(OURS), **_of_ours(DENOISE, denoises=True)}

PROGRAMS: Mapping[str, Callable[[meshes.Mesh, Amount], Smoother]] = {
    **OWN_RUNS,
    KEPT: ours_on_the_first_surface,
    "libigl, cotangent + CG": libigl,
    "libigl, cotangent + Cholesky": partial(libigl, cholesky=True),
    "Blender Laplacian Smooth": partial(blender, modifier="LAPLACIANSMOOTH", lambda_factor=1.0),
    "Blender Smooth": partial(blender, modifier="SMOOTH"),
    # Without the correction: smoothing is what is compared.
    "Blender Corrective Smooth": partial(
        blender, modifier="CORRECTIVE_SMOOTH", use_only_smooth=True
    ),
    "MeshLab Laplacian": partial(meshlab, name="apply_coord_laplacian_smoothing"),
    "MeshLab Taubin": partial(meshlab, name="apply_coord_taubin_smoothing"),
}
"""By name in the tables. CGAL's program is cgal/smooth_shape.cpp."""


def main() -> None:
    """Time one program."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", choices=PROGRAMS)
    parser.add_argument("mesh", type=Path)
    parser.add_argument("--tau", type=float, required=True)
    parser.add_argument("--time", type=float, required=True)
    parser.add_argument("--patience", type=float, default=20.0, help="seconds")
    arguments = parser.parse_args()
    mesh = meshes.read(arguments.mesh)
    smoother = PROGRAMS[arguments.program](mesh, Amount(arguments.tau, arguments.time))
    before = resident_memory()
    start = time.process_time()
    one = smoother(1)
    four = None
    if one.seconds <= arguments.patience:
        start = time.process_time()
        four = smoother(4)
    processor = time.process_time() - start
    moved = (four or one).positions - mesh.vertices
    result = {
        "one": one.seconds,
        "four": four.seconds if four else None,
        "step": four.step if four else None,
        "processor": processor,
        "moved": float(np.sqrt(np.mean(np.sum(np.square(moved), axis=1)))),
        "before": before,
        "peak": peak_memory(),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
