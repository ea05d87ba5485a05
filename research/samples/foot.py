"""A right foot: heel, arch, ankle bones, five toes with nails. Lengths are centimetres.

The sole is at z = 0, the toes point along -y, the big toe is on the -x side. The foot is 25
long; the leg is cut 17 above the ground.
"""

from __future__ import annotations

import numpy as np

from .implicit import Array, Ellipsoid, HalfSpace, Solid, Tube, polyline, tilted, vector

TOES = (
    # root, knuckle, last joint, tip; radii there; nail half width
    (
        ((-2.65, -6.0, 1.8), (-2.95, -8.2, 1.6), (-2.98, -9.9, 1.35), (-2.78, -11.4, 1.15)),
        (1.45, 1.16, 1.2, 0.95),
        0.8,
    ),
    (
        ((-0.7, -6.6, 1.8), (-0.72, -8.9, 1.95), (-0.72, -10.4, 1.4), (-0.72, -11.2, 0.85)),
        (0.95, 0.74, 0.71, 0.64),
        0.5,
    ),
    (
        ((0.75, -6.2, 1.7), (0.86, -8.3, 1.8), (0.9, -9.65, 1.25), (0.85, -10.4, 0.8)),
        (0.9, 0.69, 0.66, 0.59),
        0.45,
    ),
    (
        ((2.1, -5.5, 1.5), (2.36, -7.4, 1.6), (2.4, -8.6, 1.1), (2.28, -9.3, 0.72)),
        (0.88, 0.65, 0.61, 0.55),
        0.4,
    ),
    (
        ((3.35, -4.4, 1.2), (3.72, -6.1, 1.3), (3.72, -7.2, 0.95), (3.5, -7.85, 0.65)),
        (0.88, 0.63, 0.58, 0.52),
        0.36,
    ),
)
"""Big toe first."""


def solid() -> Solid:
    """Return the foot as an implicit solid."""
    foot = Solid()
    _leg_and_heel(foot)
    _instep(foot)
    _sole(foot)
    for knots, radii, nail in TOES:
        _toe(foot, np.array(knots), np.array(radii), nail)
    foot.carve(HalfSpace((0.0, 0.0, 17.0), (0.0, 0.0, -1.0)), 2.6)
    return foot


def _leg_and_heel(foot: Solid) -> None:
    foot.add(
        Tube(
            polyline((0, 8.4, 5.0), (0, 8.2, 9.0), (0, 8.0, 13.5), (0, 7.7, 19.0)),
            (3.15, 2.95, 3.5, 4.5),
        )
    )
    foot.add(Ellipsoid((0, 10.1, 2.7), (2.75, 2.95, 2.75)), 1.5)
    tendon = polyline((0, 12.3, 3.8), (0, 11.5, 7.0), (0, 11.1, 10.5), (0, 10.4, 16.0))
    foot.add(Tube(tendon, (0.9, 0.6, 0.75, 1.2)), 1.6)
    # Ankle bones: the inner one higher and further forward.
    foot.add(Ellipsoid((-2.95, 7.0, 7.6), (0.95, 1.25, 1.45), tilted((15, "x"))), 1.1)
    foot.add(Ellipsoid((2.85, 8.3, 6.7), (0.9, 1.05, 1.5), tilted((-10, "x"))), 1.0)
    for side in (-1.0, 1.0):
        hollow = Ellipsoid((2.9 * side, 10.4, 7.2), (0.7, 0.9, 2.2))
        foot.carve(hollow, 1.6)


def _instep(foot: Solid) -> None:
    ridge = polyline((-0.5, 6.3, 7.5), (-0.9, 2.8, 5.6), (-1.1, -1.5, 3.8), (-1.2, -6.0, 2.2))
    foot.add(Tube(ridge, (2.7, 2.3, 1.9, 1.4)), 2.0)
    outside = polyline((1.3, 9.0, 2.2), (2.5, 4.0, 2.1), (3.1, -0.5, 1.75), (3.1, -4.2, 1.5))
    foot.add(Tube(outside, (2.0, 1.75, 1.5, 1.35)), 2.0)
    inside = polyline((-1.4, 8.5, 3.0), (-2.0, 3.5, 4.0), (-2.6, -1.5, 3.0), (-2.85, -5.6, 1.9))
    foot.add(Tube(inside, (2.0, 1.7, 1.5, 1.55)), 2.0)
    foot.add(Ellipsoid((0.3, -2.5, 1.9), (3.8, 4.6, 1.7)), 1.6)
    foot.add(Ellipsoid((0.9, 2.8, 3.0), (2.5, 5.2, 2.4), tilted((12, "x"))), 2.0)
    # The balls of the big and of the little toe.
    foot.add(Ellipsoid((-3.15, -5.6, 1.5), (1.5, 1.7, 1.4)), 1.0)
    foot.add(Ellipsoid((3.3, -3.7, 1.2), (1.25, 1.6, 1.1)), 1.0)
    foot.add(Ellipsoid((0.1, -5.3, 1.55), (3.75, 2.75, 1.15), tilted((-22, "z"))), 1.2)
    # Tendons fan out from the ankle to the toes.
    for knots, _, _ in TOES[:4]:
        root = np.array(knots[0])
        middle = 0.5 * (root + vector(-0.6, 3.0, 6.2)) + vector(0.0, 0.0, 0.75)
        path = np.array([[-0.6, 3.5, 7.5], middle, root + vector(0.0, 0.4, 0.65)])
        foot.add(Tube(path, (0.35, 0.3, 0.28)), 1.1)


def _sole(foot: Solid) -> None:
    arch = polyline((-3.9, 5.2, -0.3), (-3.0, 2.0, -0.2), (-3.5, -1.2, -0.4))
    foot.carve(Tube(arch, (1.3, 2.0, 1.2)), 1.6)
    foot.carve(HalfSpace((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), 0.5)


def _toe(foot: Solid, knots: Array, radii: Array, nail: float) -> None:
    """Add a toe: root, knuckle, pad and a nail with its fold."""
    toe = Solid()
    toe.add(Tube(knots, radii * [1.0, 0.92, 0.98, 0.9]))
    pad = 0.45 * knots[2] + 0.55 * knots[3] - vector(0.0, 0.0, 0.1)
    toe.add(Ellipsoid(pad, radii[3] * np.array([1.12, 1.25, 0.95])), 0.35)
    toe.add(Ellipsoid(knots[1] + vector(0.0, 0.0, 0.25 * radii[1]), 0.8 * radii[[1, 1, 1]]), 0.4)
    along = knots[3] - knots[2]
    slope = np.degrees(np.arctan2(-along[2], -along[1]))
    turn = tilted((np.degrees(np.arctan2(along[0], -along[1])), "z"), (slope - 14.0, "x"))
    # A dome flatter than the toe makes the nail.
    middle = 0.3 * knots[2] + 0.7 * knots[3]
    thickness = 0.3 * radii[2] + 0.7 * radii[3]
    plate = np.array([nail, 1.25 * nail, 0.5 * thickness])
    toe.add(
        Ellipsoid(middle + turn @ vector(0.0, -0.15 * nail, 0.64 * thickness), plate, turn), 0.04
    )
    toe.carve(HalfSpace((0.0, 0.0, 0.12), (0.0, 0.0, 1.0)), 0.3)
    foot.add(toe, 0.3)


def detail(points: Array) -> Array:
    """Return how densely the surface should be meshed at points (n, 3), from 0 to 1."""
    weight = np.zeros(len(points))
    for knots, radii, _ in TOES:
        for joint, reach in zip(np.array(knots)[1:], radii[1:], strict=True):
            gap = np.linalg.norm(points - joint, axis=1) / (1.5 * reach)
            weight = np.maximum(weight, np.clip((2.4 - gap) / 1.4, 0.0, 1.0))
    return weight
