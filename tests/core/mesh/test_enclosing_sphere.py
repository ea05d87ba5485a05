"""The smallest sphere around points."""

import numpy as np
import pytest
from scipy.optimize import minimize
from support.meshes import icosphere

from adaptive_fairing.core.mesh.enclosing_sphere import smallest_enclosing_sphere


@pytest.mark.parametrize(
    ("points", "centre", "radius"),
    [
        ([(1, 2, 3)], (1, 2, 3), 0),
        ([(1, 2, 3)] * 5, (1, 2, 3), 0),
        ([(0, 0, 0), (4, 0, 0)], (2, 0, 0), 2),
        ([(-1, 0, 0), (1, 0, 0), (0, 0.5, 0)], (0, 0, 0), 1),  # an obtuse triangle
        ([(1, 0, 0), (-0.6, 0.8, 0), (-0.6, -0.8, 0)], (0, 0, 0), 1),  # an acute one
        ([(x, y, 0) for x in range(4) for y in range(5)], (1.5, 2, 0), 2.5),
        ([(x, y, z) for x in (0, 2) for y in (0, 3) for z in (0, 6)], (1, 1.5, 3), 3.5),
        (icosphere(3)[0], (0, 0, 0), 1),
    ],
    ids=["point", "copies", "segment", "obtuse", "acute", "grid", "box", "sphere"],
)
def test_known_spheres(points, centre, radius):
    found_centre, found_radius = smallest_enclosing_sphere(np.array(points, dtype=float))
    np.testing.assert_allclose(found_centre, centre, atol=1e-9)
    assert found_radius == pytest.approx(radius, abs=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_no_other_centre_is_nearer_to_all_points(seed):
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(50, 3)) * generator.uniform(0.01, 3, size=3)
    centre, radius = smallest_enclosing_sphere(points)

    def reach(middle):
        return np.linalg.norm(points - middle, axis=1).max()

    assert reach(centre) <= radius * (1 + 1e-12)
    # The reach is convex, so a search from the centre would find a better one if there was any.
    found = minimize(reach, centre, method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-12})
    assert found.fun >= radius * (1 - 1e-10)


@pytest.mark.parametrize("scale", [1e-38, 1e38])
def test_size_and_place_do_not_matter(scale):
    points = np.random.default_rng(3).normal(size=(100, 3))
    centre, radius = smallest_enclosing_sphere(points)
    other_centre, other_radius = smallest_enclosing_sphere(scale * (points + 5))
    np.testing.assert_allclose(other_centre / scale, centre + 5, rtol=1e-9)
    assert other_radius / scale == pytest.approx(radius, rel=1e-12)
