"""The identities (2.8): how fast area and volume change as the timestep goes to zero.

With the mean curvature vector 2 H n of x' = Delta x they read d Area/dt = -4 (integral of H^2) and
d Volume/dt = -2 (integral of H).
"""

from functools import lru_cache

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve
from support import meshes
from support.reference import interpolating_control_points

from adaptive_fairing.core import FairingSettings, LoopSpace, TriangleTopology, fair

SEMI_AXES = (1.0, 1.2, 0.85)


@lru_cache
def ellipsoid(level):
    vertices, faces = meshes.ellipsoid(level, SEMI_AXES)
    return interpolating_control_points(vertices, faces), faces


def rates(level, tau):
    """(dArea/dt, dVolume/dt) by the difference over one uniform step, and the initial measures."""
    control, faces = ellipsoid(level)
    settings = FairingSettings(
        method="uniform", tau=tau, steps=1, normalize=False, cg_tolerance=1e-13
    )
    result = fair(control, faces, settings)
    step, initial = result.steps[0], result.initial
    return (step.area - initial.area) / tau, (step.volume - initial.volume) / tau, initial


def orders(errors):
    errors = np.abs(np.asarray(errors))
    return np.log2(errors[:-1] / errors[1:])


def integral_of_mean_curvature():
    """Of the exact ellipsoid: 2 pi times its mean width, by the support function (Minkowski)."""
    cosine, weights = np.polynomial.legendre.leggauss(60)
    angle = 2 * np.pi * np.arange(120) / 120
    sine = np.sqrt(1 - cosine**2)
    direction = np.stack(
        [sine * np.cos(angle)[:, None], sine * np.sin(angle)[:, None], cosine + 0 * angle[:, None]]
    )
    support = np.linalg.norm(np.asarray(SEMI_AXES)[:, None, None] * direction, axis=0)
    return 2 * np.pi * 2 * np.sum(support * weights / 2) / len(angle)


def test_rates_converge_with_order_one_in_the_timestep():
    """On a fixed mesh the limit is known: d Area = -(L x)^T M^-1 (L x)."""
    control, faces = ellipsoid(2)
    space = LoopSpace(TriangleTopology(faces, len(control)))
    gradient = space.stiffness_matrix(control) @ control
    velocity = -spsolve(space.mass_matrix(control).tocsc(), gradient)
    area_rate = np.sum(gradient * velocity)
    step = 1e-5
    volume_rate = (
        space.measures(control + step * velocity).volume
        - space.measures(control - step * velocity).volume
    ) / (2 * step)

    taus = (4e-4, 2e-4, 1e-4)
    area_errors = [rates(2, tau)[0] / area_rate - 1 for tau in taus]
    volume_errors = [rates(2, tau)[1] / volume_rate - 1 for tau in taus]
    for errors in (area_errors, volume_errors):
        assert abs(errors[-1]) < 2e-3
        np.testing.assert_allclose(orders(errors), 1, atol=0.1)


def test_area_rate_is_minus_four_times_the_curvature_energy():
    """In the limit of fine meshes; both sides from the program, with the observed order."""
    errors = []
    for level in (2, 3, 4):
        area_rate, _, initial = rates(level, 1e-6)
        errors.append(area_rate / (-4 * initial.curvature_energy) - 1)
    assert abs(errors[-1]) < 3e-3
    assert (orders(errors) > 1).all()


def test_volume_rate_is_minus_twice_the_integral_of_mean_curvature():
    errors = []
    for level in (2, 3, 4):
        volume_rate = rates(level, 1e-6)[1]
        errors.append(volume_rate / (-2 * integral_of_mean_curvature()) - 1)
    assert abs(errors[-1]) < 2e-5
    assert (orders(errors) > 1.8).all()


def test_the_exact_integral_itself():
    """The mean width of a sphere is its diameter."""
    assert integral_of_mean_curvature() == pytest.approx(4 * np.pi * np.mean(SEMI_AXES), rel=0.01)
