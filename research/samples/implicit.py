"""Implicit solids: ellipsoids, tubes and half-spaces joined and carved with smooth blends.

A field is negative inside, positive outside and close to a distance near the surface. Every
primitive has a box; outside the box (grown by the blend width) it cannot touch the zero set,
so it is evaluated only inside. That keeps solids of several hundred primitives cheap.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

FAR = 1e3
"""Field value of empty space, larger than any shape."""


class Primitive(Protocol):
    """A shape with a bounding box and a distance-like field."""

    lower: Array
    upper: Array

    def distance(self, points: Array) -> Array:
        """Return the field at points (n, 3)."""


def rotation(degrees: float, axis: str) -> Array:
    """Return the (3, 3) matrix turning by `degrees` about coordinate axis "x", "y" or "z"."""
    angle = np.radians(degrees)
    cosine, sine = np.cos(angle), np.sin(angle)
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[first, first] = matrix[second, second] = cosine
    matrix[first, second], matrix[second, first] = -sine, sine
    return matrix


class Ellipsoid:
    """Ellipsoid with semi-axes `radii`, its local axes being the columns of `axes`."""

    def __init__(self, centre: ArrayLike, radii: ArrayLike, axes: Array | None = None) -> None:
        self.centre = np.asarray(centre, dtype=float)
        self.radii = np.asarray(radii, dtype=float)
        self.axes = np.eye(3) if axes is None else axes
        half_box = np.sqrt((self.axes**2) @ self.radii**2)
        self.lower, self.upper = self.centre - half_box, self.centre + half_box

    def distance(self, points: Array) -> Array:
        """Return the field, whose gradient has length one on the surface."""
        local = (points - self.centre) @ self.axes
        level = np.linalg.norm(local / self.radii, axis=1)
        slope = np.linalg.norm(local / self.radii**2, axis=1)
        deepest = -self.radii.min()
        return np.where(level < 1e-6, deepest, level * (level - 1.0) / np.maximum(slope, 1e-9))


class Tube:
    """Round tube along a smooth curve, its radius varying from knot to knot.

    `stretch` squeezes space along the axes before the tube is evaluated: (1, 1, 0.5) makes
    the cross-sections half as high as they are wide.
    """

    def __init__(
        self,
        knots: ArrayLike,
        radii: ArrayLike,
        pieces: int = 8,
        stretch: ArrayLike = (1.0, 1.0, 1.0),
    ) -> None:
        knots = np.asarray(knots, dtype=float)
        radii = np.broadcast_to(np.asarray(radii, dtype=float), (len(knots),))
        curve = smooth_curve(np.column_stack([knots, radii]), pieces)
        self.stretch = np.asarray(stretch, dtype=float)
        self.path, self.radii = curve[:, :3], np.maximum(curve[:, 3], 1e-3)
        reach = self.radii[:, None] * self.stretch
        self.lower = (self.path - reach).min(axis=0)
        self.upper = (self.path + reach).max(axis=0)

    def distance(self, points: Array) -> Array:
        """Return the distance to the nearest point of the curve, minus the radius there."""
        path, points = self.path / self.stretch, points / self.stretch
        nearest, radius = np.full(len(points), FAR), np.zeros(len(points))
        for k, start in enumerate(path[:-1]):
            along = path[k + 1] - start
            offset = points - start
            share = np.clip(offset @ along / max(along @ along, 1e-12), 0.0, 1.0)
            gap = np.linalg.norm(offset - share[:, None] * along, axis=1)
            closer = gap < nearest
            nearest[closer] = gap[closer]
            width = self.radii[k] + share * (self.radii[k + 1] - self.radii[k])
            radius[closer] = width[closer]
        return (nearest - radius) * self.stretch.min()


@dataclass
class HalfSpace:
    """All points behind the plane through `point` with outward `normal`."""

    point: ArrayLike
    normal: ArrayLike

    def __post_init__(self) -> None:
        self.lower, self.upper = np.full(3, -FAR), np.full(3, FAR)

    def distance(self, points: Array) -> Array:
        """Return the signed distance to the plane."""
        normal = np.asarray(self.normal, dtype=float)
        return (points - np.asarray(self.point)) @ (normal / np.linalg.norm(normal))


@dataclass
class Formula:
    """A field given by a function of points (n, 3), of use inside a box only."""

    formula: Callable[[Array], Array]
    lower: Array
    upper: Array

    def distance(self, points: Array) -> Array:
        """Return the function's values."""
        return self.formula(points)


@dataclass
class Placed:
    """A primitive turned or mirrored by `axes` (columns) and moved to `origin`."""

    primitive: Primitive
    origin: ArrayLike
    axes: Array

    def __post_init__(self) -> None:
        low, high = self.primitive.lower, self.primitive.upper
        corners = np.array(np.meshgrid(*np.stack([low, high], axis=1))).reshape(3, -1).T
        corners = corners @ self.axes.T + np.asarray(self.origin)
        self.lower, self.upper = corners.min(axis=0), corners.max(axis=0)

    def distance(self, points: Array) -> Array:
        """Return the primitive's field in its own frame."""
        return self.primitive.distance((points - np.asarray(self.origin)) @ self.axes)


def mirrored(primitive: Primitive) -> Placed:
    """Return the mirror image of a primitive in the plane x = 0."""
    return Placed(primitive, np.zeros(3), np.diag([-1.0, 1.0, 1.0]))


@dataclass
class Solid:
    """Primitives applied in order, each joined to or carved from what came before."""

    operations: list[tuple[Primitive, float, bool]] = field(default_factory=list)

    def add(self, primitive: Primitive, blend: float = 0.0) -> None:
        """Join a primitive; `blend` is the width over which the seam is rounded."""
        self.operations.append((primitive, blend, False))

    def carve(self, primitive: Primitive, blend: float = 0.0) -> None:
        """Cut a primitive away; `blend` is the width over which the edge is rounded."""
        self.operations.append((primitive, blend, True))

    def add_pair(self, primitive: Primitive, blend: float = 0.0) -> None:
        """Join a primitive and its mirror image in x = 0."""
        self.add(primitive, blend)
        self.add(mirrored(primitive), blend)

    def carve_pair(self, primitive: Primitive, blend: float = 0.0) -> None:
        """Cut away a primitive and its mirror image in x = 0."""
        self.carve(primitive, blend)
        self.carve(mirrored(primitive), blend)

    @property
    def lower(self) -> Array:
        """Smallest corner of the joined primitives' box."""
        return np.min([item.lower for item, _, carved in self.operations if not carved], axis=0)

    @property
    def upper(self) -> Array:
        """Largest corner of the joined primitives' box."""
        return np.max([item.upper for item, _, carved in self.operations if not carved], axis=0)

    def distance(self, points: Array) -> Array:
        """Return the field at points (n, 3)."""
        values = np.full(len(points), FAR)
        for primitive, blend, carved in self.operations:
            margin = 1.5 * blend + 0.5 * float(np.min(primitive.upper - primitive.lower))
            near = np.all(
                (points > primitive.lower - margin) & (points < primitive.upper + margin), axis=1
            )
            if not near.any():
                continue
            other = primitive.distance(points[near])
            if carved:
                values[near] = -smooth_minimum(-values[near], other, blend)
            else:
                values[near] = smooth_minimum(values[near], other, blend)
        return values


def smooth_minimum(first: Array, second: Array, width: float) -> Array:
    """Return min(first, second), rounded by a parabola where they differ by less than `width`."""
    smaller = np.minimum(first, second)
    if width <= 0.0:
        return smaller
    overlap = np.maximum(width - np.abs(first - second), 0.0) / width
    return smaller - 0.25 * width * overlap**2


def smooth_curve(knots: Array, pieces: int) -> Array:
    """Return points of the Catmull-Rom curve through `knots` (n, d), `pieces` per interval."""
    if len(knots) == 2:
        return knots
    padded = np.concatenate([2 * knots[:1] - knots[1:2], knots, 2 * knots[-1:] - knots[-2:-1]])
    before, start, end, after = padded[:-3], padded[1:-2], padded[2:-1], padded[3:]
    share = (np.arange(pieces) / pieces)[None, :, None]
    before, start, end, after = (item[:, None, :] for item in (before, start, end, after))
    linear = end - before
    square = 2 * before - 5 * start + 4 * end - after
    cube = 3 * start - before - 3 * end + after
    inner = start + 0.5 * share * (linear + share * (square + share * cube))
    return np.concatenate([inner.reshape(-1, knots.shape[1]), knots[-1:]])


def gradient(solid: Primitive, points: Array, step: float) -> Array:
    """Return the field's gradient (n, 3) from its differences over `step` in four directions."""
    result = np.zeros_like(points)
    for corner in np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float):
        result += solid.distance(points + step * corner)[:, None] * corner
    return result / (4.0 * step)


def project(solid: Primitive, points: Array, step: float, rounds: int = 3) -> Array:
    """Return points moved onto the zero set by Newton steps no longer than `step`."""
    for _ in range(rounds):
        slope = gradient(solid, points, 0.1 * step)
        square = np.maximum(np.einsum("nd,nd->n", slope, slope), 1e-4)
        length = solid.distance(points) / square
        length = np.clip(length, -step, step)
        points = points - length[:, None] * slope
    return points


def tilted(*turns: tuple[float, str]) -> Array:
    """Return the product of rotations given as (degrees, axis), the last applied first."""
    matrix = np.eye(3)
    for degrees, axis in turns:
        matrix = matrix @ rotation(degrees, axis)
    return matrix


def vector(x: float, y: float, z: float) -> Array:
    """Return an offset as an array (3,)."""
    return np.array([x, y, z])


def polyline(*points: Sequence[float]) -> Array:
    """Return points as an (n, 3) array."""
    return np.array(points, dtype=float)
