"""The third group: twelve shapes unlike those of the other two, looked at once, at the end."""

from __future__ import annotations

import numpy as np

from research.samples.implicit import Ellipsoid, Formula, Solid, Tube, rotation
from research.samples.meshing import dense_mesh
from tools.geometry.triangles import FloatArray, convex_hull, grid_faces, spiral, torus

from .cad import Part
from .meshing import MeshArrays, graded, near, remeshed, uneven
from .turned import lathe


def block() -> MeshArrays:
    """Return an even cube with slanted corners, a stepped hole and a slot."""
    part = Part().box((-1, -1, -1), (1, 1, 1))
    for k in range(4):
        angle = np.pi * (k + 0.5) / 2
        x, y = 1.25 * np.cos(angle), 1.25 * np.sin(angle)
        part.box((x - 0.2, y - 0.2, -2), (x + 0.2, y + 0.2, 2), cut=True, turn=45 * (k % 2))
    part.cylinder((0, 0, 0), (0, 0, 1), 0.45, 4, cut=True, segments=8)
    part.cylinder((0, 0, 1), (0, 0, 1), 0.65, 0.8, cut=True, segments=8)
    part.box((-2, -0.15, -1.5), (2, 0.15, -0.6), cut=True)
    return remeshed(*part.arrays(), 0.06)


def die() -> MeshArrays:
    """Return an even solid of many facets, its corners on a golden spiral."""
    return remeshed(*convex_hull(spiral(26)), 0.05, 15.0)


def faceted_ring() -> MeshArrays:
    """Return an even ring of flat facets, sharp all over."""
    return remeshed(*torus(1.4, 0.55, (10, 5), shift=0.25), 0.06, 10.0)


def heat_sink() -> MeshArrays:
    """Return a plate with a row of thin fins, its flat sides coarse."""
    part = Part().box((-2, -1.2, 0), (2, 1.2, 0.35))
    for k in range(9):
        x = -1.8 + 0.45 * k
        part.box((x - 0.08, -1.1, 0.2), (x + 0.08, 1.1, 1.3 - 0.05 * (k - 4) ** 2))
    for x in (-1.57, 1.57):
        part.cylinder((x, 0, 0), (0, 0, 1), 0.1, 3, cut=True)
    return _stretched(part, 0.11, (0.8, 0.8, 0.8))


def house() -> MeshArrays:
    """Return a house with a roof, a chimney, recessed windows and steps at the door."""
    gable = ((1.2, 1.2), (1.45, 1.1), (0.0, 2.3), (-1.45, 1.1), (-1.2, 1.2))
    roof = np.array([(x, y, z) for x, z in gable for y in (-1.75, 1.75)])
    part = Part().box((-1.2, -1.6, 0), (1.2, 1.6, 1.25))
    part.solid(*convex_hull(roof))
    part.box((0.5, 0.6, 1.5), (0.85, 0.95, 2.6))
    for y in (-1.0, 0.0, 1.0):
        for side in (-1.2, 1.2):
            part.box((side - 0.12, y - 0.25, 0.5), (side + 0.12, y + 0.25, 1.0), cut=True)
    part.box((-0.3, -1.8, 0), (0.3, -1.45, 0.9), cut=True)
    for k in range(3):
        low = -0.5 - 0.01 * k, -1.6 - 0.2 * (3 - k), -0.02 - 0.01 * k
        part.box(low, (0.5 + 0.01 * k, -1.57, 0.1 * (k + 1)))
    return _stretched(part, 0.12, (0.0, 0.9, 0.0))


def propeller() -> MeshArrays:
    """Return a hub with five straight twisted blades: sharp rims, thin sides."""
    part = Part().cylinder((0, 0, 0), (0, 0, 1), (0.5, 0.35), 0.9, segments=48)
    for k in range(5):
        turn = 2 * np.pi * k / 5
        out = np.linspace(0.2, 1.9, 12)
        pitch = np.radians(65 - 22 * out)
        chord, thick = 0.34 - 0.06 * out, 0.05
        corners = []
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            along = a * chord * np.cos(pitch) - b * thick * np.sin(pitch)
            up = a * chord * np.sin(pitch) + b * thick * np.cos(pitch)
            x = out * np.cos(turn) - along * np.sin(turn)
            y = out * np.sin(turn) + along * np.cos(turn)
            corners.append(np.stack([x, y, up], axis=1))
        points = np.stack(corners, axis=1).reshape(-1, 3)
        sides = grid_faces(12, 4, (False, True))
        ends = np.array([[0, 2, 1], [0, 3, 2], [44, 45, 46], [44, 46, 47]])
        part.solid(points, np.concatenate([sides, ends])[:, ::-1])
    part.cylinder((0, 0, 0), (0, 0, 1), 0.15, 3, cut=True, segments=32)
    vertices, faces = remeshed(*part.arrays(), 0.045)
    return graded(vertices, faces, 14_000, near(vertices, (0, 0, 0.4), 0.8, 0.003))


def wall() -> MeshArrays:
    """Return the front of a wall with niches, a door, pilasters and a rosette: open, even."""
    part = Part().box((-2, 0, 0), (2, 0.4, 3))
    for side in (-1, 1):
        part.box((1.7 * side - 0.15, -0.12, 0.2), (1.7 * side + 0.15, 0.1, 2.8))
        part.box((1.05 * side - 0.25, -0.5, 0.65), (1.05 * side + 0.25, 0.18, 1.75), cut=True)
    part.box((-0.45, -0.5, -0.5), (0.45, 0.25, 1.3), cut=True)
    part.cylinder((0, -0.1, 1.3), (0, 1, 0), 0.45, 0.7, cut=True)
    part.cylinder((0, 0, 2.35), (0, 1, 0), (0.3, 0.42), 0.24, segments=8)
    vertices, faces = remeshed(*part.arrays(), 0.055)
    faces = faces[vertices[faces][..., 1].max(axis=1) < 0.399]
    used, faces = np.unique(faces, return_inverse=True)
    return vertices[used], faces.reshape(-1, 3).astype(np.int32)


def fish() -> MeshArrays:
    """Make a fish with fins, scales, an eye and a mouth, dense at its head."""
    solid = Solid()
    solid.add(Ellipsoid((0, 0, 0), (1.3, 0.36, 0.62)))
    solid.add(Ellipsoid((-1.25, 0, 0.02), (0.5, 0.15, 0.24)), 0.3)
    for lift in (-0.5, 0.5):
        tail = [(-1.5, 0, 0), (-1.85, 0, lift), (-2.15, 0, 1.5 * lift)]
        solid.add(Tube(tail, (0.14, 0.16, 0.05), stretch=(1, 0.5, 1)), 0.12)
    back = [(0.5, 0, 0.55), (0.0, 0, 0.85), (-0.6, 0, 0.6)]
    solid.add(Tube(back, (0.08, 0.2, 0.05), stretch=(1, 0.4, 1)), 0.1)
    for side in (-1, 1):
        fin = [(0.45, 0.3 * side, -0.15), (0.15, 0.6 * side, -0.3), (-0.2, 0.75 * side, -0.4)]
        solid.add(Tube(fin, (0.1, 0.14, 0.04), stretch=(1, 1, 0.5)), 0.08)
        solid.add(Ellipsoid((0.88, 0.22 * side, 0.16), (0.1, 0.06, 0.1)), 0.03)
    solid.carve(Ellipsoid((1.32, 0, -0.12), (0.2, 0.2, 0.035), rotation(10, "y")), 0.03)

    def formula(points: FloatArray) -> FloatArray:
        x, _, z = points.T
        body = np.exp(-((x / 0.8) ** 4) - (z / 0.45) ** 4)
        return solid.distance(points) + 0.012 * body * np.sin(22 * x) * np.sin(22 * z)

    vertices, faces = dense_mesh(Formula(formula, solid.lower, solid.upper), 0.022)
    return uneven(vertices, faces, 24_000, near(vertices, (1.0, 0, 0), 0.7, 0.1))


def hand() -> MeshArrays:
    """Make a hand of five bent fingers with knuckles and nails."""
    solid = Solid()
    solid.add(Ellipsoid((0, 0, 0), (0.62, 0.25, 0.7)))
    solid.add(Tube([(0, 0, -0.5), (0, 0.05, -1.3)], (0.42, 0.36)), 0.25)
    for k, length in enumerate((0.95, 1.15, 1.05, 0.8)):
        x, lean = -0.45 + 0.3 * k, 0.12 * (k - 1.5)
        knots = [
            (x, 0, 0.4),
            (x + 0.4 * lean, -0.08, 0.4 + 0.45 * length),
            (x + 0.8 * lean, -0.3, 0.4 + 0.8 * length),
            (x + lean, -0.5, 0.4 + 0.9 * length),
        ]
        solid.add(Tube(knots, (0.16, 0.14, 0.125, 0.1)), 0.1)
        solid.add(Ellipsoid(np.add(knots[1], (0, 0.06, 0)), (0.14, 0.12, 0.1)), 0.05)
        tip = np.add(knots[3], (0, 0.02, 0.1))
        solid.add(Ellipsoid(tip, (0.07, 0.07, 0.03), rotation(60, "x")), 0.02)
    thumb = [(0.4, -0.05, -0.35), (0.85, -0.2, 0.05), (0.95, -0.35, 0.5)]
    solid.add(Tube(thumb, (0.22, 0.18, 0.12)), 0.15)
    vertices, faces = dense_mesh(solid, 0.024)
    return uneven(vertices, faces, 18_000, near(vertices, (0, -0.3, 1.2), 0.8, 0.08))


def seashell() -> MeshArrays:
    """Make a ribbed shell: a tube that winds up and grows, its edges growing with it."""
    n_along, n_around = 420, 30
    t = np.linspace(0, 1, n_along)[:, None]
    angle, size = 7 * np.pi * t, np.exp(2.6 * t) / np.exp(2.6)
    across = 2 * np.pi * np.arange(n_around)[None] / n_around
    rib = 1 + 0.07 * np.cos(150 * t + 0 * across) * np.clip(8 * (1 - t), 0, 1)
    radius = size * (0.62 + 0.4 * rib * np.cos(across))
    height = 1.9 * (1 - size) + size * 0.42 * rib * np.sin(across)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1)
    return points.reshape(-1, 3), grid_faces(n_along, n_around, (False, True))


def brain() -> MeshArrays:
    """Make two halves with winding folds, dense on one side."""

    def formula(points: FloatArray) -> FloatArray:
        x, y, z = points.T
        wave = sum(
            np.sin(a * x + p) * np.sin(a * y + 2 * p) + np.sin(a * z - p) * np.sin(a * x + y)
            for a, p in ((7.0, 0.3), (9.0, 1.1), (11.0, 2.0))
        )
        folds = 0.05 * np.tanh(1.5 * wave)
        cleft = 0.16 * np.exp(-((x / 0.07) ** 2)) * np.clip(z + 0.6, 0, 1)
        return (
            0.8 * (np.sqrt((x / 0.95) ** 2 + (y / 1.2) ** 2 + (z / 0.85) ** 2) - 1) + folds + cleft
        )

    box = np.array([1.25, 1.5, 1.2])
    vertices, faces = dense_mesh(Formula(formula, -box, box), 0.026)
    return uneven(vertices, faces, 30_000, near(vertices, (0, -1.2, 0.3), 0.9, 0.1))


def mushroom() -> MeshArrays:
    """Make a turned cap with lamellae below and warts above, on a stem that bends."""
    profile = [(0, 0), *((0.26 - 0.1 * np.sin(2 * h), h) for h in np.linspace(0.02, 1.25, 24))]
    profile += [(r, 1.3 + 0.04 * np.sin(60 * r)) for r in np.linspace(0.3, 0.95, 60)]
    cap = np.linspace(-0.25, np.pi / 2, 40)[:-1]
    profile += [*zip(np.cos(cap), 1.5 + 0.62 * np.sin(cap), strict=True), (0, 2.12)]
    vertices, faces = remeshed(*lathe(np.array(profile), 120), 0.035, 50.0)
    generator = np.random.default_rng(23)
    way = generator.normal(size=(45, 3)) * [1, 1, 0.5] + [0, 0, 0.9]
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    spots = [0, 0, 1.5] + way * [1, 1, 0.62]
    far = np.linalg.norm(vertices[:, None] - spots, axis=2).min(axis=1)
    vertices += 0.06 * np.exp(-((far / 0.08) ** 4))[:, None] * (vertices - [0, 0, 1.3])
    vertices[:, 0] += 0.25 * np.square(vertices[:, 2] / 2 - 0.3)
    return graded(vertices, faces, 15_000, near(vertices, (0.1, 0, 2.0), 0.9, 0.01))


def _stretched(part: Part, edge: float, stretch: tuple[float, float, float]) -> MeshArrays:
    """Remesh a part evenly while it is stretched: edges come out shorter away from the origin.

    Flat sides stay flat if each lies along an axis with a stretch or at right angles to it.
    """
    vertices, faces = part.arrays()
    for k, rate in enumerate(stretch):
        if rate:
            vertices[:, k] = np.sinh(rate * vertices[:, k]) / rate
    vertices, faces = remeshed(vertices, faces, edge)
    for k, rate in enumerate(stretch):
        if rate:
            vertices[:, k] = np.arcsinh(rate * vertices[:, k]) / rate
    return vertices, faces
