"""A human head: skull, face, ears, eyes, lips and nose. Lengths are centimetres.

The z axis points up with the chin at 0 and the crown at 22.5, the face looks along -y, and the
midline is x = 0. The proportions are those of an average adult (breadth 15, length 19.5).
"""

from __future__ import annotations

import numpy as np

from .implicit import (
    Array,
    Ellipsoid,
    Formula,
    HalfSpace,
    Placed,
    Solid,
    Tube,
    polyline,
    tilted,
    vector,
)

EYE = np.array([3.2, -6.95, 11.3])
EYE_RADIUS = 1.22
EAR = np.array([7.15, 1.0, 10.1])
DETAIL_BALLS = (
    (EAR + vector(0.6, 0.6, 0.0), 3.0, 1.0),
    (EYE + vector(0.0, -0.6, 0.0), 1.6, 1.0),
    (np.array([0.9, -10.6, 7.4]), 1.6, 0.9),
    (np.array([1.2, -9.6, 4.6]), 1.7, 1.0),
    (np.array([0.0, -9.0, 8.0]), 4.5, 0.22),
)
"""Centre, radius and weight of the parts that stay densely meshed (mirrored in x = 0)."""


def solid() -> Solid:
    """Return the head as an implicit solid."""
    head = Solid()
    _skull(head)
    _jaw_and_neck(head)
    _eyes(head)
    _nose(head)
    _mouth(head)
    ear = Placed(_ear(), EAR, tilted((-27.0, "z"), (-12.0, "x"), (1.0, "y")))
    head.add_pair(ear, 0.35)
    head.carve(HalfSpace((0.0, 0.0, -7.5), (0.0, 0.0, 1.0)), 1.6)
    return head


def _skull(head: Solid) -> None:
    head.add(Ellipsoid((0, 0.9, 14.0), (7.35, 9.0, 8.4)))
    head.add(Ellipsoid((0, -3.2, 15.0), (6.2, 6.2, 6.0)), 2.0)
    head.add(Ellipsoid((0, 3.4, 10.5), (6.4, 6.3, 6.0)), 2.0)
    # Temples, cheekbones, the front of the face and the brow.
    head.add(Ellipsoid((0, -3.3, 8.2), (5.7, 5.5, 7.0)), 1.5)
    head.add_pair(Ellipsoid((4.35, -5.7, 9.1), (1.9, 2.1, 1.5), tilted((-35, "z"))), 1.8)
    head.add_pair(
        Tube(polyline((0.9, -9.0, 12.8), (3.0, -8.5, 13.3), (5.0, -6.9, 12.9)), (0.5, 0.6, 0.35)),
        1.8,
    )
    head.add_pair(
        Tube(polyline((4.7, -5.6, 9.0), (5.9, -3.0, 9.4), (6.3, 0.0, 9.8)), (0.8, 0.7, 0.6)), 2.4
    )
    # Cheeks, chewing muscles and the hollow behind the eye.
    head.add_pair(Ellipsoid((3.3, -5.3, 6.0), (2.3, 2.5, 2.6)), 2.0)
    head.add_pair(Ellipsoid((4.5, -1.8, 5.8), (1.5, 2.3, 3.2)), 2.0)
    head.add_pair(Ellipsoid((4.9, -3.6, 11.6), (1.5, 2.6, 2.2)), 2.0)


def _jaw_and_neck(head: Solid) -> None:
    jaw = polyline((5.75, 0.2, 6.5), (5.35, -1.0, 3.4), (3.9, -4.6, 1.9), (1.2, -7.6, 1.35))
    head.add_pair(Tube(jaw, (1.2, 1.35, 1.3, 1.35)), 2.2)
    head.add(Ellipsoid((0, -7.7, 1.6), (1.9, 1.75, 1.55)), 1.4)
    head.add(Ellipsoid((0, -5.9, 4.9), (3.5, 3.7, 2.8)), 1.6)
    head.add(
        Tube(
            polyline((0, 1.6, 8.0), (0, 2.3, 0.0), (0, 2.6, -5.0), (0, 2.7, -9.0)),
            (5.3, 5.0, 5.2, 5.8),
        ),
        2.2,
    )
    head.add(Tube(polyline((0, -1.2, 3.0), (0, -0.9, -3.0), (0, -0.2, -9.0)), (3.3, 3.3, 3.6)), 1.6)
    # The floor of the mouth, the neck's straps and the larynx.
    head.add(Ellipsoid((0, -3.2, 2.6), (3.9, 4.6, 2.5), tilted((10, "x"))), 2.2)
    strap = polyline((5.3, 2.6, 6.5), (4.3, 0.1, 0.5), (2.7, -2.2, -5.0), (1.3, -2.9, -9.0))
    head.add_pair(Tube(strap, (1.0, 1.0, 0.85, 0.6)), 1.6)
    head.add(Ellipsoid((0, -3.9, -2.2), (0.8, 0.8, 1.1)), 1.4)


def _eyes(head: Solid) -> None:
    socket = Ellipsoid(EYE + vector(-0.1, -1.75, 0.3), (1.9, 1.1, 1.05), tilted((-20, "z")))
    head.carve_pair(socket, 1.3)
    lids = Solid()
    lids.add(Ellipsoid(EYE, [EYE_RADIUS + 0.24] * 3))
    aperture = Formula(_aperture, EYE - vector(1.7, 2.2, 1.0), EYE + vector(1.7, 0.0, 1.0))
    lids.carve(aperture, 0.28)
    head.add_pair(lids, 0.5)
    # The crease above the upper lid.
    arc = np.linspace(-1.0, 1.0, 7)
    crease = EYE + np.column_stack([1.5 * arc, -1.3 + 0.7 * arc**2, 1.03 - 0.5 * arc**2])
    head.carve_pair(Tube(crease, (0.03, 0.08, 0.1, 0.1, 0.1, 0.09, 0.04)), 0.3)
    # The ball; a hollow stands for iris and pupil, as in marble.
    eyeball = Solid()
    eyeball.add(Ellipsoid(EYE, [EYE_RADIUS] * 3))
    eyeball.carve(Ellipsoid(EYE + vector(0, -1.32, 0.06), (0.46, 0.38, 0.46)), 0.12)
    head.add_pair(eyeball, 0.14)
    # The inner corner's tear bump.
    head.add_pair(Ellipsoid(EYE + vector(-1.42, -0.55, -0.12), (0.22, 0.25, 0.16)), 0.15)


def _aperture(points: Array) -> Array:
    """Return the almond between the lids, seen from the front: negative inside."""
    across, height = points[:, 0] - EYE[0], points[:, 2] - EYE[2]
    lift = height - 0.06 * across
    share = 1.0 - (across / 1.5) ** 2
    upper, lower = lift - 0.66 * share, -lift - 0.5 * share
    return np.maximum(np.maximum(upper, lower), points[:, 1] - EYE[1] + 0.2)


def _nose(head: Solid) -> None:
    bridge = polyline((0, -8.35, 12.2), (0, -8.75, 11.3), (0, -9.75, 9.8), (0, -10.75, 8.3))
    head.add(Tube(bridge, (0.75, 0.6, 0.7, 0.8)), 1.0)
    head.add(Ellipsoid((0, -9.3, 8.6), (1.25, 1.6, 1.6), tilted((25, "x"))), 1.2)
    head.add(Ellipsoid((0, -10.95, 7.95), (0.85, 0.85, 0.75)), 0.6)
    head.add_pair(Ellipsoid((1.25, -9.65, 7.45), (0.62, 1.0, 0.68), tilted((-18, "z"))), 0.45)
    # A groove frames the wing of the nose.
    wing = polyline((1.45, -10.2, 8.25), (1.95, -9.55, 8.05), (2.0, -9.0, 7.3))
    head.carve_pair(Tube(wing, (0.06, 0.14, 0.08)), 0.35)
    nostril = Ellipsoid((0.68, -10.1, 6.75), (0.34, 0.62, 0.7), tilted((-14, "z"), (-20, "x")))
    head.carve_pair(nostril, 0.2)
    head.add(
        Tube(polyline((0, -11.05, 7.45), (0, -10.5, 7.1), (0, -9.6, 6.75)), (0.42, 0.3, 0.35)), 0.25
    )


def _mouth(head: Solid) -> None:
    # The lines from the nose to the corners of the mouth, and the groove under the nose.
    fold = polyline((2.1, -8.9, 7.3), (3.0, -8.4, 6.0), (3.5, -7.9, 4.4))
    head.carve_pair(Tube(fold, (0.1, 0.15, 0.08)), 1.0)
    head.carve(Tube(polyline((0, -10.05, 6.5), (0, -10.35, 5.75)), (0.22, 0.34)), 0.4)
    upper = polyline(
        (-2.6, -8.3, 4.72),
        (-1.7, -9.0, 4.98),
        (-0.62, -9.62, 5.18),
        (0, -9.62, 5.02),
        (0.62, -9.62, 5.18),
        (1.7, -9.0, 4.98),
        (2.6, -8.3, 4.72),
    )
    head.add(Tube(upper, (0.15, 0.38, 0.46, 0.5, 0.46, 0.38, 0.15)), 0.3)
    lower = polyline(
        (-2.5, -8.3, 4.5),
        (-1.5, -9.05, 4.12),
        (-0.5, -9.5, 3.95),
        (0.5, -9.5, 3.95),
        (1.5, -9.05, 4.12),
        (2.5, -8.3, 4.5),
    )
    head.add(Tube(lower, (0.12, 0.45, 0.56, 0.56, 0.45, 0.12)), 0.3)
    line = polyline(
        (-2.6, -8.6, 4.6),
        (-1.6, -9.4, 4.62),
        (-0.7, -9.95, 4.66),
        (0, -10.1, 4.56),
        (0.7, -9.95, 4.66),
        (1.6, -9.4, 4.62),
        (2.6, -8.6, 4.6),
    )
    head.carve(Tube(line, 0.09), 0.24)
    head.carve(
        Tube(polyline((-1.6, -8.8, 3.0), (0, -9.55, 2.85), (1.6, -8.8, 3.0)), (0.1, 0.3, 0.1)), 0.9
    )


def _ear() -> Solid:
    """Return the left ear around its middle: x outwards, y backwards, z up."""
    ear = Solid()
    ear.add(Ellipsoid((-0.15, 0.25, 0.3), (0.28, 1.55, 2.85), tilted((-8, "x"))))
    ear.add(Ellipsoid((-0.6, 0.0, -0.2), (0.9, 1.2, 1.6)), 0.6)
    helix = polyline(
        (0.05, -0.35, -0.15),
        (0.25, -0.95, 0.65),
        (0.3, -1.0, 1.7),
        (0.32, -0.25, 2.75),
        (0.32, 0.9, 2.9),
        (0.32, 1.75, 2.0),
        (0.3, 1.85, 0.7),
        (0.2, 1.4, -0.7),
        (0.1, 0.75, -1.8),
        (0.0, 0.05, -2.5),
    )
    ear.add(Tube(helix, (0.2, 0.27, 0.3, 0.33, 0.33, 0.31, 0.28, 0.25, 0.24, 0.2)), 0.22)
    ear.add(Ellipsoid((0.0, -0.25, -2.55), (0.3, 0.72, 0.8)), 0.4)
    fold = polyline(
        (0.2, 0.35, 1.75), (0.3, 0.85, 0.9), (0.3, 0.95, 0.0), (0.28, 0.55, -1.0), (0.25, 0.0, -1.5)
    )
    ear.add(Tube(fold, (0.2, 0.26, 0.28, 0.26, 0.26)), 0.25)
    ear.add(
        Tube(
            polyline((0.15, -0.45, 1.35), (0.25, 0.2, 1.15), (0.3, 0.85, 0.75)), (0.1, 0.18, 0.22)
        ),
        0.25,
    )
    # The bowl with the ear canal, and the small flap in front of it.
    ear.carve(Ellipsoid((0.2, 0.0, -0.35), (0.6, 0.72, 0.95), tilted((-10, "x"))), 0.25)
    ear.carve(Ellipsoid((-0.3, -0.45, -0.3), (0.7, 0.3, 0.3)), 0.2)
    ear.add(Ellipsoid((0.15, -0.85, -0.5), (0.3, 0.32, 0.5), tilted((15, "z"))), 0.2)
    return ear


def detail(points: Array) -> Array:
    """Return how densely the surface should be meshed at points (n, 3), from 0 to 1."""
    points = points * np.sign(points[:, :1] + 1e-9) ** np.array([1, 0, 0])
    weight = np.zeros(len(points))
    for centre, radius, strength in DETAIL_BALLS:
        gap = np.linalg.norm(points - centre, axis=1) / radius
        weight = np.maximum(weight, strength * np.clip((1.7 - gap) / 0.7, 0.0, 1.0))
    return weight
