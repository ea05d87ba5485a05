"""The Loop basis on single patches: against whole-mesh subdivision, differences and neighbours."""

import numpy as np
import pytest
from support import meshes
from support.reference import BruteForceSpace, fine_barycentric

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.loop.basis import basis_table, evaluate_basis
from adaptive_fairing.core.loop.patches import PatchSet
from adaptive_fairing.core.loop.quadrature import quadrature_choice

CASES = [
    pytest.param(mesh, id=name)
    for name, mesh in {
        "tetrahedron": meshes.tetrahedron(),
        "octahedron": meshes.octahedron(),
        "icosahedron": meshes.icosahedron(),
        "seven-vertex torus": meshes.seven_vertex_torus(),
        "torus of 3 x 3": meshes.torus(3, 3),
        "valences 3 to 10": meshes.random_closed(1),
        "pole of valence 44": meshes.bipyramid(44),
        "pole of valence 200": meshes.bipyramid(200),
        "open, regular": meshes.flat_hexagon(3),
        "open, irregular": meshes.bumpy_disc(0),
        "open, irregular, another": meshes.bumpy_disc(4),
        "single triangle": meshes.single_triangle(),
        "cylinder": meshes.open_cylinder(3, 1),
    }.items()
]


class PatchValues:
    """All basis functions of a mesh, evaluated triangle by triangle."""

    def __init__(self, mesh):
        vertices, self.faces = mesh
        self.n_vertices = len(vertices)
        patch_set = PatchSet(TriangleTopology(self.faces, self.n_vertices))
        self.classes = patch_set.classes
        self.patch_of = {
            int(triangle): (segment.class_index, segment.control_points[:, k])
            for segment in patch_set.segments
            for k, triangle in enumerate(segment.triangles)
        }

    def corners(self, triangle):
        """Vertices of a triangle in the order of its patch's parametric corners."""
        return self.patch_of[triangle][1][:3]

    def at(self, triangle, points):
        """Value, ∂1, ∂2, ∂11, ∂12, ∂22: (6, n_points, n_vertices)."""
        class_index, control_points = self.patch_of[triangle]
        local = evaluate_basis(self.classes[class_index], points)
        table = np.zeros((6, len(points), self.n_vertices))
        for slot, vertex in enumerate(control_points):  # a vertex may have several slots
            table[:, :, vertex] += local[:, :, slot]
        return table


def random_points(n_points, seed=0):
    """Points inside the unit triangle, some of them close to its corners."""
    generator = np.random.default_rng(seed)
    barycentric = generator.dirichlet([1, 1, 1], n_points)
    barycentric[: n_points // 2] = generator.dirichlet([0.2, 0.2, 0.2], n_points // 2)
    return np.clip(barycentric, 1e-3, None)[:, 1:] / np.clip(barycentric, 1e-3, None).sum(
        axis=1, keepdims=True
    )


@pytest.mark.parametrize("mesh", CASES)
def test_values_equal_whole_mesh_subdivision(mesh):
    basis = PatchValues(mesh)
    levels = 2 if len(basis.faces) > 100 else 3
    [(refinement, fine_faces)] = BruteForceSpace(basis.faces, (levels,)).refinements
    refinement = refinement.toarray()
    barycentric = fine_barycentric(len(basis.faces), levels)
    for triangle in range(0, len(basis.faces), 1 + len(basis.faces) // 100):
        own = np.arange(triangle, len(fine_faces), len(basis.faces))
        places, first = np.unique(barycentric[own].reshape(-1, 3), axis=0, return_index=True)
        inside = places.max(axis=1) < 1  # the corners themselves have the limit mask
        expected = refinement[fine_faces[own].ravel()[first[inside]]]
        rotation = [list(basis.faces[triangle]).index(vertex) for vertex in basis.corners(triangle)]
        points = places[inside][:, rotation][:, 1:]
        np.testing.assert_allclose(basis.at(triangle, points)[0], expected, atol=1e-13)


@pytest.mark.parametrize("mesh", CASES)
def test_partition_of_unity(mesh):
    basis = PatchValues(mesh)
    points = random_points(40)
    for patch_class in basis.classes:
        sums = evaluate_basis(patch_class, points).sum(axis=2)
        np.testing.assert_allclose(sums[0], 1, atol=1e-13)
        # Close to an extraordinary corner, derivatives of order k grow like 2^(k depth).
        np.testing.assert_allclose(sums[1:], 0, atol=1e-9)


@pytest.mark.parametrize("mesh", CASES)
def test_derivatives_equal_central_differences(mesh):
    basis = PatchValues(mesh)
    points = random_points(12, seed=3)
    step = 1e-6
    for patch_class in basis.classes[:: 1 + len(basis.classes) // 25]:
        exact = evaluate_basis(patch_class, points)
        for axis, (first, seconds) in enumerate([(1, (3, 4)), (2, (4, 5))]):
            offset = step * np.eye(2)[axis]
            difference = evaluate_basis(patch_class, points + offset)
            difference -= evaluate_basis(patch_class, points - offset)
            difference /= 2 * step
            np.testing.assert_allclose(difference[0], exact[first], atol=1e-8)
            # The second derivatives of a spline are continuous, their slope is not: first order.
            slope_scale = 1e-5 * max(1, np.abs(exact[3:]).max())
            np.testing.assert_allclose(difference[1], exact[seconds[0]], atol=slope_scale)
            np.testing.assert_allclose(difference[2], exact[seconds[1]], atol=slope_scale)


@pytest.mark.parametrize("mesh", CASES)
def test_twice_continuously_differentiable_across_patch_edges(mesh):
    """Glued along an edge, two unit triangles form a parallelogram on which the basis is C².

    At the extraordinary end points it is C¹ on the surface only; the points keep away from them.
    """
    basis = PatchValues(mesh)
    side_of = {}
    for triangle in range(len(basis.faces)):
        corners = basis.corners(triangle)
        for k in range(3):
            side_of[int(corners[k]), int(corners[(k + 1) % 3])] = (triangle, k)
    along = np.array([0.03, 0.3, 0.5, 0.71])
    inner = [edge for edge in side_of if edge[0] < edge[1] and edge[::-1] in side_of]
    assert inner or len(basis.faces) == 1
    for start, end in inner[:: 1 + len(inner) // 60]:
        left = _edge_derivatives(basis, *side_of[start, end], along)
        right = _edge_derivatives(basis, *side_of[end, start], 1 - along)
        # From the right side: its own edge direction is -e, its way to the far corner is -f.
        value, e, f, ee, ef, ff = right
        scale = max(1, np.abs(left[3:]).max())
        for side, other in zip(left, (value, -e, -f, ee, ef, ff), strict=True):
            np.testing.assert_allclose(side, other, atol=1e-11 * scale)


def _edge_derivatives(basis, triangle, corner, along):
    """Derivatives along the edge from ``corner`` (e) and towards the side opposite its end (f).

    Points are at ``along`` on the edge from ``corner`` to the next one. f leads from the corner to
    the third one, which from the other side of the edge is parallel to its own f, reversed.
    """
    parametric = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    start, end, third = np.roll(parametric, -corner, axis=0)
    table = basis.at(triangle, start + along[:, None] * (end - start))
    e, f = end - start, third - start

    def first(d):
        return d[0] * table[1] + d[1] * table[2]

    def second(d, g):
        return (
            d[0] * g[0] * table[3] + (d[0] * g[1] + d[1] * g[0]) * table[4] + d[1] * g[1] * table[5]
        )

    return table[0], first(e), first(f), second(e, e), second(e, f), second(f, f)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_tables_hold_the_basis_at_points_that_cover_the_triangle(tolerance):
    basis = PatchValues(meshes.bumpy_disc(0))
    choice = quadrature_choice(tolerance)
    for patch_class in basis.classes:
        table = basis_table(patch_class, choice)
        np.testing.assert_allclose(table.weights.sum(axis=1), 0.5, rtol=1e-13)
        assert (table.weights > 0).all()
        np.testing.assert_allclose(table.values[0].sum(axis=1), 1, atol=1e-13)
        # The divergence theorem: the integral of ∂1 is a boundary integral of the values.
        edge, weights = np.polynomial.legendre.leggauss(5)
        edge, weights = (edge + 1) / 2, weights / 2
        slanted = evaluate_basis(patch_class, np.column_stack([edge, 1 - edge]))[0]
        straight = evaluate_basis(patch_class, np.column_stack([0 * edge, edge]))[0]
        expected = np.tile(weights @ (slanted - straight), (2, 1))
        np.testing.assert_allclose(table.weights @ table.values[1], expected, atol=5 * tolerance)
