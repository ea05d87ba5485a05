"""A crocodile: long flat snout with teeth, rows of scutes on back and tail. Centimetres.

It is 100 long. The head looks along -x, z is up, the belly is at about z = 1. The body is
modelled straight and then bent sideways in a gentle S.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .implicit import Array, Ellipsoid, Formula, Solid, Tube, polyline, tilted, vector

SPINE = np.array(
    [
        # x, height of the axis, half height, half width
        [-19.0, 5.2, 2.3, 3.1],
        [-15.0, 5.2, 2.7, 3.3],
        [-10.0, 5.2, 3.5, 4.6],
        [-3.0, 5.2, 4.0, 5.7],
        [5.0, 5.2, 4.0, 5.9],
        [12.0, 5.3, 3.7, 4.9],
        [17.0, 5.4, 3.1, 3.7],
        [24.0, 5.0, 2.6, 2.6],
        [34.0, 4.0, 2.2, 1.75],
        [44.0, 3.1, 1.8, 1.15],
        [54.0, 2.3, 1.2, 0.65],
        [61.0, 1.7, 0.5, 0.3],
    ]
)
"""The trunk and tail: ellipses across the x axis."""


def bend(x: Array) -> Array:
    """Return how far the spine is moved sideways (to +y) at x."""
    tail = np.clip(x - 12.0, 0.0, None)
    head = np.clip(-8.0 - x, 0.0, None)
    return 0.0075 * tail**2 - 0.000085 * tail**3 - 0.006 * head**2


@dataclass
class Bent:
    """A solid bent sideways along its spine."""

    straight: Solid

    def __post_init__(self) -> None:
        shift = bend(np.linspace(self.straight.lower[0], self.straight.upper[0], 200))
        reach = np.array([0.0, 1.0, 0.0])
        self.lower = self.straight.lower + reach * shift.min()
        self.upper = self.straight.upper + reach * shift.max()

    def distance(self, points: Array) -> Array:
        """Return the field of the straight solid at the unbent points."""
        shift = np.column_stack([np.zeros(len(points)), bend(points[:, 0]), np.zeros(len(points))])
        return self.straight.distance(points - shift)


def solid() -> Bent:
    """Return the crocodile as an implicit solid."""
    body = Solid()
    body.add(Formula(_trunk, np.array([-19.0, -6.5, 0.0]), np.array([62.0, 6.5, 10.0])))
    _neck_and_skull(body)
    _legs(body)
    _scutes(body)
    return Bent(body)


def _section(x: Array) -> tuple[Array, Array, Array]:
    """Return the axis height, half height and half width of the trunk at x."""
    knots = SPINE[:, 0]
    return tuple(_interpolate(x, knots, SPINE[:, k]) for k in (1, 2, 3))


def _interpolate(x: Array, knots: Array, values: Array) -> Array:
    """Return the cubic Hermite interpolant with finite-difference slopes, constant outside."""
    slopes = np.gradient(values, knots)
    x = np.clip(x, knots[0], knots[-1])
    k = np.clip(np.searchsorted(knots, x) - 1, 0, len(knots) - 2)
    width = knots[k + 1] - knots[k]
    t = (x - knots[k]) / width
    return (
        (1 + 2 * t) * (1 - t) ** 2 * values[k]
        + t * (1 - t) ** 2 * width * slopes[k]
        + t**2 * (3 - 2 * t) * values[k + 1]
        - t**2 * (1 - t) * width * slopes[k + 1]
    )


def _trunk(points: Array) -> Array:
    x = points[:, 0]
    height, tall, wide = _section(x)
    across, up = points[:, 1] / wide, (points[:, 2] - height) / tall
    # Flatter below than an ellipse: the belly rests on the ground.
    level = (np.abs(across) ** 2.4 + np.abs(up) ** 2.4) ** (1.0 / 2.4)
    slope = np.sqrt((across / wide) ** 2 + (up / tall) ** 2) / np.maximum(level, 1e-6)
    gap = (level - 1.0) / np.maximum(slope, 1.0 / np.maximum(wide, tall))
    beyond = np.maximum(SPINE[0, 0] - x, x - SPINE[-1, 0])
    return np.maximum(gap, beyond)


def _neck_and_skull(body: Solid) -> None:
    body.add(Ellipsoid((-19.5, 0, 5.3), (4.5, 3.1, 2.5)), 1.5)
    # Lower jaw and upper jaw, each broad behind and long in front.
    lower = polyline((-20.0, 0, 4.3), (-25.0, 0, 4.0), (-32.0, 0, 3.9), (-39.3, 0, 4.0))
    body.add(Tube(lower, (3.0, 2.6, 1.95, 1.5), stretch=(1, 1, 0.5)), 0.6)
    upper = polyline(
        (-20.0, 0, 6.0), (-25.5, 0, 5.9), (-32.0, 0, 5.4), (-36.0, 0, 5.25), (-39.6, 0, 5.25)
    )
    body.add(Tube(upper, (3.1, 2.7, 2.1, 1.8, 1.7), stretch=(1, 1, 0.5)), 0.35)
    # The closed mouth is solid just behind the teeth.
    core = polyline(
        (-20.0, 0, 4.9), (-25.5, 0, 4.8), (-32.0, 0, 4.7), (-36.0, 0, 4.65), (-39.4, 0, 4.65)
    )
    body.add(Tube(core, (2.9, 2.5, 1.9, 1.6, 1.45), stretch=(1, 1, 0.35)), 0.2)
    body.add(Ellipsoid((-22.0, 0, 7.0), (3.6, 2.2, 0.95)), 0.9)
    body.add(
        Tube(
            polyline((-26.0, 0, 6.9), (-31.0, 0, 6.3), (-37.0, 0, 5.8)),
            (1.3, 0.8, 0.5),
            stretch=(1, 1, 0.6),
        ),
        0.9,
    )
    # The tip of the snout with two nostrils.
    body.add(Ellipsoid((-39.7, 0, 5.75), (1.3, 1.3, 0.62)), 0.4)
    for side in (-1.0, 1.0):
        body.add(Ellipsoid((-40.0, 0.5 * side, 6.2), (0.6, 0.42, 0.35)), 0.2)
        body.carve(Ellipsoid((-40.25, 0.52 * side, 6.5), (0.3, 0.16, 0.25)), 0.1)
        _eye(body, side)
        body.add(
            Tube(
                polyline(
                    (-26.0, 1.5 * side, 7.0), (-30.0, 1.05 * side, 6.4), (-34.0, 0.95 * side, 6.0)
                ),
                (0.35, 0.3, 0.2),
            ),
            0.45,
        )
        # The gape between the jaws, and the muscle behind it.
        gape = polyline(
            (-21.5, 2.95 * side, 5.5),
            (-24.0, 2.85 * side, 4.95),
            (-27.0, 2.55 * side, 5.05),
            (-32.0, 2.1 * side, 4.6),
            (-36.0, 1.82 * side, 4.75),
            (-39.5, 1.62 * side, 4.6),
        )
        body.carve(Tube(gape, (0.1, 0.14, 0.14, 0.14, 0.14, 0.12)), 0.2)
        body.add(Ellipsoid((-19.5, 2.5 * side, 4.7), (2.4, 1.1, 1.6)), 0.8)
        _teeth(body, side)


def _eye(body: Solid, side: float) -> None:
    socket = np.array([-24.0, 1.55 * side, 7.35])
    body.add(Ellipsoid(socket, (1.35, 0.85, 0.85)), 0.45)
    body.carve(Ellipsoid(socket + vector(-0.05, 0.75 * side, 0.12), (0.62, 0.35, 0.36)), 0.15)
    body.add(Ellipsoid(socket + vector(-0.05, 0.42 * side, 0.12), (0.48, 0.42, 0.4)), 0.05)
    body.add(
        Tube(
            polyline(
                socket + vector(-1.0, 0.5 * side, 0.45),
                socket + vector(0.0, 0.62 * side, 0.72),
                socket + vector(1.1, 0.4 * side, 0.55),
            ),
            (0.15, 0.24, 0.15),
        ),
        0.2,
    )


def _teeth(body: Solid, side: float) -> None:
    """Add the upper teeth, which overlap the closed lower jaw."""
    for number, x in enumerate(np.arange(-39.0, -25.5, 0.95)):
        width = np.interp(x, [-39.5, -36.0, -32.0, -25.0], [1.52, 1.78, 2.02, 2.6])
        size = 1.0 + 0.3 * (number % 4 == 1)
        root = np.array([x, (width - 0.12) * side, 4.9])
        tip = root - np.array([0.0, 0.05 * side, 0.8 * size])
        body.add(Tube(np.array([root, tip]), (0.32 * size, 0.12)), 0.1)


def _legs(body: Solid) -> None:
    for side in (-1.0, 1.0):
        for hip, knee, ankle, toe_x, thick in (
            ((-9.5, 4.3, 4.6), (-7.4, 8.6, 4.3), (-10.6, 9.9, 1.1), -12.6, 1.25),
            ((13.0, 3.6, 4.6), (9.6, 8.2, 5.0), (13.2, 9.4, 1.1), 10.6, 1.6),
        ):
            flip = np.array([1.0, side, 1.0])
            path = np.array([hip, knee, ankle]) * flip
            limb = Solid()
            limb.add(Tube(path, np.array([1.45, 1.0, 0.72]) * thick))
            foot = np.array(ankle)
            for spread in (-1.3, -0.45, 0.45, 1.3):
                tip = np.array([toe_x + 0.35 * abs(spread), foot[1] + 0.6 + 1.25 * spread, 0.75])
                middle = 0.5 * (foot + tip) + vector(0.0, 0.0, 0.25)
                toe = np.array([foot, middle, tip]) * flip
                limb.add(Tube(toe, (0.7, 0.5, 0.34)), 0.3)
                claw = (
                    np.array(
                        [
                            tip,
                            tip + vector(-0.55, 0.1 * spread, -0.1),
                            tip + vector(-0.95, 0.12 * spread, -0.45),
                        ]
                    )
                    * flip
                )
                limb.add(Tube(claw, (0.24, 0.18, 0.05)), 0.08)
            body.add(limb, 1.0)


def _scutes(body: Solid) -> None:
    """Add keeled plates in rows: four to six on the back, two and then one on the tail."""
    for x in np.arange(-13.5, 18.0, 1.75):
        rows = (0.16, 0.46, 0.74) if -9.0 < x < 13.0 else (0.18, 0.52)
        for place in rows:
            for side in (-1.0, 1.0):
                _scute(body, x + 0.5 * (place > 0.3) * (place < 0.6), side * place, 0.62)
    for number, x in enumerate(np.arange(18.5, 59.5, 1.7)):
        height = 1.15 - 0.01 * number
        if x < 40.0:
            for side in (-1.0, 1.0):
                _fin(body, x, side * 0.45 * np.interp(x, [18, 40], [1.0, 0.35]), height)
        else:
            _fin(body, x, 0.0, height * np.interp(x, [40, 60], [1.25, 0.7]))
    for x, place in ((-17.5, 0.25), (-17.5, 0.65), (-15.7, 0.3)):
        for side in (-1.0, 1.0):
            _scute(body, x, side * place, 0.7)


def _surface(x: float, place: float) -> tuple[Array, float]:
    """Return the point on the back at x and at `place` of the half width, and its tilt."""
    height, tall, wide = (float(item) for item in _section(np.array(x)))
    up = (1.0 - abs(place) ** 2.4) ** (1.0 / 2.4)
    steep = (abs(place) ** 1.4 * np.sign(place) / wide) / max(up**1.4 / tall, 1e-6)
    return np.array([x, place * wide, height + up * tall]), float(np.degrees(np.arctan(steep)))


def _scute(body: Solid, x: float, place: float, size: float) -> None:
    """Add a plate with a keel along the spine."""
    point, tilt = _surface(x, place)
    turn = tilted((-tilt, "x"))
    body.add(Ellipsoid(point, (1.05 * size, 0.95 * size, 0.34 * size), turn), 0.12)
    keel = point + turn @ vector(0.2 * size, 0.0, 0.3 * size)
    body.add(
        Ellipsoid(keel, (0.85 * size, 0.22 * size, 0.55 * size), turn @ tilted((-18.0, "y"))), 0.15
    )


def _fin(body: Solid, x: float, place: float, height: float) -> None:
    """Add an upright plate of the tail's crest, leaning backwards."""
    point, _ = _surface(x, place)
    body.add(
        Ellipsoid(point + vector(0.25, 0.0, 0.1), (0.7, 0.28, height), tilted((24.0, "y"))), 0.25
    )


def detail(points: Array) -> Array:
    """Return how densely the surface should be meshed at points (n, 3), from 0 to 1."""
    straight = points - np.column_stack(
        [np.zeros(len(points)), bend(points[:, 0]), np.zeros(len(points))]
    )
    x, up = straight[:, 0], straight[:, 2]
    height, tall, _ = _section(x)
    snout = np.clip((-23.0 - x) / 6.0, 0.0, 1.0) * 0.6 + np.clip((-19.0 - x) / 3.0, 0.0, 0.4)
    back = 0.22 * np.clip((up - height - 0.45 * tall) / (0.25 * tall), 0.0, 1.0)
    back *= np.clip((x + 19.0) / 2.0, 0.0, 1.0) * np.interp(x, [16.0, 40.0, 60.0], [1.0, 0.8, 0.7])
    toes = 0.16 * np.clip((1.8 - up) / 0.6, 0.0, 1.0) * (np.abs(straight[:, 1]) > 6.0)
    return np.max([snout, back, toes], axis=0)
