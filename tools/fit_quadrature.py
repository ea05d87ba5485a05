"""Fit the quadrature rule of irregular patches, and print it as constants for `fitted_rule.py`.

Ten points, symmetric, whose weights depend on the valences of the corners: a sum of weights of the
regular patch and of shifts by each extraordinary corner.  The points and the weights of the regular
patch are best for polynomials; the shifts minimise the errors of the local matrices of M and L on
patches of random surfaces, against a fine composite rule.

    python tools/fit_quadrature.py
"""

from __future__ import annotations

import sys
from math import factorial
from pathlib import Path

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import Delaunay

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from adaptive_fairing.core import TriangleTopology, mesh_density
from adaptive_fairing.core.fem.differential_geometry import metric_at
from adaptive_fairing.core.loop.basis import evaluate_basis, refined_table
from adaptive_fairing.core.loop.patch_class import PatchClass
from adaptive_fairing.core.loop.patches import PatchSet
from adaptive_fairing.core.loop.quadrature import triangle_rule

VALENCES = (4, 5, 7, 8, 9, 10)
SURFACES = (
    # seed, jitter in units of the edges, stretching: thin triangles count as well
    (1, 0.25, 1.0),
    (2, 0.4, 1.0),
    (3, 0.15, 1.0),
    (4, 0.25, 5.0),
    (5, 0.15, 30.0),
    (6, 0.1, 30.0),
    (7, 0.1, 100.0),
)
SAMPLES_PER_CLASS = 24
GOOD_ERROR = 2e-3
"""Relative error below which all are equally good, in the fit that does not let the worst rule."""

ROUNDS = 5

FloatArray = np.ndarray


def barycentric(corner: float, a: float, b: float) -> FloatArray:
    """Points of an orbit of three, an orbit of six and the centre, (10, 3)."""
    c = 1 - a - b
    three = [np.roll([1 - 2 * corner, corner, corner], k) for k in range(3)]
    six = [(a, b, c), (b, c, a), (c, a, b), (b, a, c), (a, c, b), (c, b, a)]
    return np.array([*three, *six, (1 / 3, 1 / 3, 1 / 3)])


def weights_for_polynomials(points: FloatArray) -> tuple[FloatArray, float]:
    """Weights that are best for polynomials up to degree 8, and their largest error."""
    rows, exact = [], []
    for i in range(9):
        for j in range(9 - i):
            # Nearly exact up to degree 4; the higher ones matter less and less.
            importance = {5: 30, 6: 3, 7: 1, 8: 1}.get(i + j, 1000)
            rows.append(importance * points[:, 1] ** i * points[:, 2] ** j)
            exact.append(importance * factorial(i) * factorial(j) / factorial(i + j + 2))
    system, right = np.array(rows), np.array(exact)
    weights = np.linalg.lstsq(system, right, rcond=None)[0]
    return weights, float(np.abs(system @ weights - right).max())


def best_points() -> tuple[FloatArray, FloatArray]:
    """Points with the smallest error for polynomials, and their weights."""

    def error(parameters: FloatArray) -> float:
        points = barycentric(*parameters)
        return weights_for_polynomials(points)[1] if points.min() > 0.01 else 1e3

    found = minimize(error, (0.1, 0.05, 0.3), method="Nelder-Mead", options={"maxiter": 2000})
    print("points:", *(f"{value:.9f}" for value in found.x))
    points = barycentric(*found.x)
    return points, weights_for_polynomials(points)[0]


def random_surface(seed: int, jitter: float, n_side: int = 141) -> tuple[FloatArray, FloatArray]:
    """Make a bumpy sheet over a Delaunay triangulation of a jittered grid, relaxed twice."""
    generator = np.random.default_rng(seed)
    plane = np.stack(np.meshgrid(np.arange(n_side), np.arange(n_side)), axis=-1).reshape(-1, 2)
    plane = plane.astype(float)
    plane[:, 0] += 0.5 * (plane[:, 1] % 2)
    plane[:, 1] *= np.sqrt(3) / 2
    plane += jitter * generator.normal(size=plane.shape)
    faces = Delaunay(plane).simplices
    start, along, across = plane[faces].transpose(1, 0, 2)
    (ax, ay), (bx, by) = (along - start).T, (across - start).T
    area = ax * by - ay * bx
    faces = np.where((area > 0)[:, None], faces, faces[:, ::-1])[np.abs(area) > 1e-3]
    topology = TriangleTopology(faces, len(plane))
    adjacency = topology.adjacency().astype(float)
    for _ in range(2):
        mean = (adjacency @ plane) / np.maximum(topology.ring_size, 1)[:, None]
        plane = np.where(topology.on_boundary[:, None], plane, mean)
    noise = generator.normal(size=(len(plane), 3)) * (0.05, 0.05, 0.12)
    return np.column_stack([plane, np.zeros(len(plane))]) + noise, faces


def samples() -> dict[PatchClass, list[tuple[FloatArray, FloatArray]]]:
    """Control points (K, n, 3) and densities (K, n) of patches, by class."""
    found: dict[PatchClass, list[tuple[FloatArray, FloatArray]]] = {}
    for seed, jitter, stretch in SURFACES:
        vertices, faces = random_surface(seed, jitter)
        vertices[:, 0] *= stretch
        topology = TriangleTopology(faces, len(vertices))
        density = mesh_density(topology, vertices)
        patches = PatchSet(topology)
        for segment in patches.segments:
            patch_class = patches.classes[segment.class_index]
            ring_sizes = {corner.ring_size for corner in patch_class}
            if any(corner.is_boundary for corner in patch_class):
                continue
            if ring_sizes == {6} or not ring_sizes <= {6, *VALENCES}:
                continue
            control = segment.control_points[:, :SAMPLES_PER_CLASS]
            found.setdefault(patch_class, []).append((vertices[control], density[control]))
    return found


def integrands(basis: FloatArray, points: FloatArray, timestep: FloatArray) -> FloatArray:
    """Local matrices' integrands of M and L at points, (n_points, 2, pairs, n)."""
    a, b = np.triu_indices(basis.shape[2])
    phi, d1, d2 = basis[:3]
    tangents = np.einsum("iqk,knd->idqn", basis[1:3], points)
    shape = tangents.shape[2:]
    metric = metric_at(tangents.reshape(2, 3, -1))
    area, g11, g12, g22 = (
        x.reshape(shape)[:, None] for x in (metric.area_element, metric.g11, metric.g12, metric.g22)
    )
    mass = (phi[:, a] * phi[:, b])[..., None] * area / (phi @ timestep)[:, None]
    stiffness = (d1[:, a] * d1[:, b])[..., None] * g22 + (d2[:, a] * d2[:, b])[..., None] * g11
    stiffness -= (d1[:, a] * d2[:, b] + d2[:, a] * d1[:, b])[..., None] * g12
    return np.stack([mass, stiffness / area], axis=1)


def prepared(
    patch_class: PatchClass, group: list[tuple[FloatArray, FloatArray]], points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Integrands at the rule's points, and the integrals; in units of the largest entry."""
    position = np.concatenate([x for x, _ in group], axis=1)
    timestep = np.concatenate([t for _, t in group], axis=1)
    fine = refined_table(patch_class, triangle_rule(6), 4)
    exact = np.zeros(())
    for part in np.array_split(np.arange(len(fine.weights)), 12):
        values = integrands(fine.values[:, part], position, timestep)
        exact = exact + np.tensordot(fine.weights[part], values, axes=1)
    scale = np.abs(exact).max(axis=1, keepdims=True)
    return integrands(evaluate_basis(patch_class, points[:, 1:]), position, timestep) / scale, (
        exact / scale
    )


def main() -> None:
    """Fit, print the constants and the errors before and after."""
    points, regular = best_points()
    print("weights:", *(f"{regular[k]:.9f}" for k in (0, 3, 9)))
    # Where a point lies as seen from a corner: its coordinates there, and the other two in order.
    seen = np.stack(
        [np.column_stack([points[:, i], np.sort(np.delete(points, i, 1), 1)]) for i in range(3)]
    ).round(9)
    kinds = np.unique(seen.reshape(-1, 3), axis=0)
    kind_of = np.array([[int((kinds == s).all(1).argmax()) for s in corner] for corner in seen])
    sharing = np.bincount(kind_of[0], minlength=len(kinds))
    # Shifts that add up to zero, so that constants are integrated exactly.
    balanced = np.linalg.svd(sharing[None].astype(float))[2][1:].T
    n_shifts = len(VALENCES) * len(kinds)
    basis = np.kron(np.eye(len(VALENCES)), balanced)

    systems = []
    for patch_class, group in samples().items():
        values, exact = prepared(patch_class, group, points)
        design = np.zeros((len(points), n_shifts))
        for i, corner in enumerate(patch_class):
            if corner.ring_size != 6:
                first = VALENCES.index(corner.ring_size) * len(kinds)
                design[np.arange(len(points)), first + kind_of[i]] += 1
        systems.append((patch_class, values, exact, design))

    shifts = np.zeros(n_shifts)
    for _ in range(ROUNDS):  # each patch with the weight of its error so far: no outlier rules
        left, right = 1e-9 * np.eye(n_shifts), np.zeros(n_shifts)
        for _, values, exact, design in systems:
            error = np.tensordot(regular + design @ shifts, values, axes=1) - exact
            influence = 1 / np.hypot(np.abs(error).max(axis=(0, 1)), GOOD_ERROR)
            flat = (values * influence).reshape(len(points), -1)
            wanted = ((exact - np.tensordot(regular, values, axes=1)) * influence).ravel()
            slope = design.T @ flat
            left += slope @ slope.T
            right += slope @ wanted
        reduced = np.linalg.solve(basis.T @ left @ basis, basis.T @ right)
        shifts = basis @ reduced
    print("kinds:", kinds.tolist())
    for valence, row in zip(VALENCES, shifts.reshape(len(VALENCES), -1), strict=True):
        print(f"    {valence}: ({', '.join(f'{1e6 * value:.0f}e-6' for value in row)}),")

    print("median errors of M and L, without and with the shifts; smallest weight")
    for patch_class, values, exact, design in systems:
        weights = regular + design @ shifts
        medians = [
            np.median(np.abs(np.tensordot(w, values, axes=1) - exact).max(axis=1), axis=1)
            for w in (regular, weights)
        ]
        ring_sizes = [corner.ring_size for corner in patch_class]
        print(ring_sizes, *(f"{value:.1e}" for pair in medians for value in pair), weights.min())


if __name__ == "__main__":
    main()
