"""Fit the quadrature rule of irregular patches, and print it as constants for `fitted_quadrature`.

Ten points, symmetric; the weight of a point is a sum of one number for each corner, which depends
on the valence there and on where the point lies as seen from it.  M and L have weights of their
own.  Points and numbers minimise the errors of assembled entries, relative to the largest one of
their matrix, on convex hulls of random points, some of them bumpy, against a fine composite rule.

    python tools/fit_quadrature.py [--evaluations 150]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.optimize import minimize

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from adaptive_fairing.core import LoopSpace, TriangleTopology, mesh_density
from adaptive_fairing.core.fem.differential_geometry import metric_at
from adaptive_fairing.core.loop.basis import basis_table, evaluate_basis
from adaptive_fairing.core.loop.fitted_quadrature import is_fitted
from adaptive_fairing.core.loop.patch_class import PatchClass, is_regular_patch
from adaptive_fairing.core.loop.patches import PatchSet
from adaptive_fairing.core.loop.quadrature import quadrature_choice
from tools.geometry.triangles import convex_hull, unit

VALENCES = (4, 5, 6, 7, 8, 9, 10)
N_KINDS = 6
N_HULLS = 100
FIRST_POINTS = (0.0625, 0.0762, 0.3087)
"""Small coordinate of the orbit of three points, two coordinates of the orbit of six."""

POWER = 5
"""Of the error that is minimised: large ones count for more."""

OUTLIER = 1.3e-3
"""Errors beyond this, of single extreme triangles, count no more than this."""

ROUNDS = 40

FloatArray = np.ndarray


def barycentric(small: float, a: float, b: float) -> FloatArray:
    """Points of an orbit of three, an orbit of six and the centre, (10, 3)."""
    c = 1 - a - b
    three = [np.roll([1 - 2 * small, small, small], k) for k in range(3)]
    six = [(a, b, c), (b, c, a), (c, a, b), (b, a, c), (a, c, b), (c, b, a)]
    return np.array([*three, *six, (1 / 3, 1 / 3, 1 / 3)])


def random_hull(generator: np.random.Generator, bump: float) -> tuple[FloatArray, FloatArray]:
    """Make the convex hull of 12 to 100 random points, of valences 3 to 10, and bump it."""
    while True:
        points = generator.normal(size=(int(generator.integers(12, 101)), 3))
        points = unit(points)
        _, faces = convex_hull(points)
        if np.bincount(faces.ravel()).max() <= 10:
            return points * (1 + bump * generator.normal(size=(len(points), 1))), faces


class Patches(NamedTuple):
    """Patches of one class: control points (K, n), and the matrix entry of each pair, (p, n)."""

    patch_class: PatchClass
    control: FloatArray
    entry: FloatArray
    factor: FloatArray


class Samples:
    """Errors of the upper entries of M and L of many meshes, as a function of the weights.

    Attributes
    ----------
    fitted : list of Patches
        Irregular patches that the rule is for.
    missing : (2, n_entries)
        What these have to add to M and to L, over the largest entry of the mesh.
    """

    def __init__(self, meshes: list[tuple[FloatArray, FloatArray]]) -> None:
        starts = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
        self.vertices = np.concatenate([vertices for vertices, _ in meshes])
        faces = np.concatenate([f + first for (_, f), first in zip(meshes, starts, strict=False)])
        self.n = len(self.vertices)
        topology = TriangleTopology(faces, self.n)
        self.density = mesh_density(topology, self.vertices)
        space = LoopSpace(topology, 1e-5)
        exact = [
            sparse.triu(matrix, format="coo")
            for matrix in (
                space.mass_matrix(self.vertices, timestep=self.density),
                space.stiffness_matrix(self.vertices),
            )
        ]
        self.keys = exact[0].row.astype(np.int64) * self.n + exact[0].col
        self.mesh_of = np.searchsorted(starts, exact[0].row, side="right") - 1
        largest = np.zeros((2, len(meshes)))
        for own, matrix in zip(largest, exact, strict=True):
            np.maximum.at(own, self.mesh_of, np.abs(matrix.data))
        self.scale = largest[:, self.mesh_of]
        self.missing = np.stack([matrix.data for matrix in exact])
        self.fitted: list[Patches] = []
        self._sort_patches(PatchSet(topology))
        self.missing /= self.scale

    def _sort_patches(self, patches: PatchSet) -> None:
        groups: dict[int, list[FloatArray]] = {}
        for segment in patches.segments:
            groups.setdefault(segment.class_index, []).append(segment.control_points)
        for index, found in groups.items():
            patch_class, control = patches.classes[index], np.concatenate(found, axis=1)
            a, b = np.triu_indices(len(control))
            low, high = np.minimum(control[a], control[b]), np.maximum(control[a], control[b])
            entry = np.searchsorted(self.keys, low.astype(np.int64) * self.n + high)
            # Two different control points that are one vertex count twice on the diagonal.
            factor = 1.0 + ((low == high) & (a != b)[:, None])
            group = Patches(patch_class, control, entry, factor)
            if is_fitted(patch_class) and not is_regular_patch(patch_class):
                self.fitted.append(group)
                continue
            table = basis_table(patch_class, quadrature_choice(1e-3))
            integrals = np.einsum(
                "zq,zqpn->zpn", table.weights, self.integrands(table.values, group)
            )
            for k in range(2):
                self.missing[k] -= self._sum(group, integrals[k])

    def _sum(self, group: Patches, values: FloatArray) -> FloatArray:
        return np.bincount(group.entry.ravel(), values.ravel(), len(self.keys))

    def integrands(self, basis: FloatArray, group: Patches) -> FloatArray:
        """Local matrices' integrands of M and L at points, (2, n_points, pairs, n)."""
        phi, d1, d2 = basis[:3]
        a, b = np.triu_indices(basis.shape[2])
        tangents = np.einsum("iqk,knd->idqn", basis[1:3], self.vertices[group.control])
        shape = tangents.shape[2:]
        metric = metric_at(tangents.reshape(2, 3, -1))
        area, g11, g12, g22 = (
            x.reshape(shape)[:, None]
            for x in (metric.area_element, metric.g11, metric.g12, metric.g22)
        )
        timestep = (phi @ self.density[group.control])[:, None]
        mass = (phi[:, a] * phi[:, b])[..., None] * area / timestep
        stiffness = (d1[:, a] * d1[:, b])[..., None] * g22 + (d2[:, a] * d2[:, b])[..., None] * g11
        stiffness -= (d1[:, a] * d2[:, b] + d2[:, a] * d1[:, b])[..., None] * g12
        return group.factor * np.stack([mass, stiffness / area])

    def influence(self, points: FloatArray) -> FloatArray:
        """Compute what a number of each valence and kind adds, (2, n_numbers, n_entries)."""
        kind = kinds(points)
        columns = np.zeros((2, len(VALENCES) * N_KINDS, len(self.keys)))
        for group in self.fitted:
            values = self.integrands(evaluate_basis(group.patch_class, points[:, 1:]), group)
            for corner, kind_of_point in zip(group.patch_class, kind, strict=True):
                first = N_KINDS * VALENCES.index(corner.ring_size)
                for k in range(N_KINDS):
                    sums = values[:, kind_of_point == k].sum(axis=1)
                    for z in range(2):
                        columns[z, first + k] += self._sum(group, sums[z])
        return columns / self.scale[:, None]

    def largest_errors(self, errors: FloatArray) -> FloatArray:
        """Largest error of each mesh."""
        largest = np.zeros(self.mesh_of.max() + 1)
        np.maximum.at(largest, self.mesh_of, np.abs(errors))
        return largest


def kinds(points: FloatArray) -> FloatArray:
    """Kind of a point, one of six, as seen from each corner, (3, n_points)."""
    return np.unique(points.T.round(6), return_inverse=True)[1].reshape(3, -1)


def best_weights(
    points: FloatArray, columns: FloatArray, missing: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Find the numbers whose sums are the weights, for one matrix; return also the errors."""
    sharing = np.bincount(kinds(points)[0], minlength=N_KINDS)
    # Three corners with a sixth each make weights of sum 1/2: constants are integrated exactly.
    even = np.full(columns.shape[0], 1 / 60)
    balanced = np.linalg.svd(sharing[None].astype(float))[2][1:].T
    basis = np.kron(np.eye(len(VALENCES)), balanced)
    start, slopes = columns.T @ even - missing, columns.T @ basis
    shifts, importance, damping = np.zeros(basis.shape[1]), np.ones(len(missing)), 1.0
    for _ in range(ROUNDS):
        weighted = slopes * importance[:, None]
        normal = slopes.T @ weighted + 1e-9 * np.eye(len(shifts))
        errors = start + slopes @ shifts
        shifts -= damping * np.linalg.solve(normal, weighted.T @ errors)
        size = np.abs(start + slopes @ shifts)
        bounded = np.clip(size, 1e-5, OUTLIER)
        importance = (bounded / OUTLIER) ** (POWER - 2) * bounded / np.maximum(size, 1e-5)
        damping = 1.5 / (POWER - 1)
    return even + basis @ shifts, start + slopes @ shifts


def main() -> None:
    """Fit; print the constants, and the errors on meshes that were fitted and on others."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--evaluations", type=int, default=0, help="in the search for the points")
    arguments = parser.parse_args()
    fitted, others = (
        Samples([random_hull(np.random.default_rng((seed, k)), 0.1 * (k % 2)) for k in range(n)])
        for seed, n in ((1, N_HULLS), (2, N_HULLS))
    )

    def errors_of(coordinates: FloatArray) -> float:
        points = barycentric(*coordinates)
        if points.min() < 0.02:
            return 1.0
        columns, total = fitted.influence(points), 0.0
        for k, importance in ((0, 0.3), (1, 1.0)):
            errors = best_weights(points, columns[k], fitted.missing[k])[1]
            largest = np.minimum(fitted.largest_errors(errors), 3 * OUTLIER)
            total += importance * np.mean(largest**3) ** (1 / 3)
        return total

    coordinates = np.array(FIRST_POINTS)
    if arguments.evaluations:
        options = {"maxfev": arguments.evaluations}
        found = minimize(errors_of, coordinates, method="Nelder-Mead", options=options)
        coordinates = found.x.round(4)
    points = barycentric(*coordinates)
    print("points:", coordinates.tolist())
    columns, others_columns = fitted.influence(points), others.influence(points)
    for k, name in enumerate("ML"):
        numbers, errors = best_weights(points, columns[k], fitted.missing[k])
        rounded = numbers.round(6)
        unseen = others.largest_errors(others_columns[k].T @ rounded - others.missing[k])
        print(f"{name}, in millionths, by valence:")
        for valence, row in zip(VALENCES, rounded.reshape(len(VALENCES), -1), strict=True):
            print(f"    {valence}: ({', '.join(f'{1e6 * value:.0f}' for value in row)}),")
        for title, largest in (("fitted", fitted.largest_errors(errors)), ("others", unseen)):
            quantiles = np.quantile(largest, (0.5, 0.9, 1))
            print(f"largest errors, {title}:", *(f"{value:.1e}" for value in quantiles))


if __name__ == "__main__":
    main()
