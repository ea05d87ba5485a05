"""No vertex gets further from its input position than the settings allow."""

import numpy as np
import pytest
from support.meshes import noisy_ball

from adaptive_fairing.core import FairingSettings, fair
from adaptive_fairing.core.problem.deviation import limited


@pytest.mark.parametrize("place", [0.0, 1e3, 1e7])
@pytest.mark.parametrize("method", ["uniform", "adaptive_timestep", "adaptive_tensor"])
def test_no_vertex_is_further_than_the_limit(method, place):
    vertices, faces = noisy_ball(2, 0.05)
    vertices = vertices + place
    free = fair(vertices, faces, FairingSettings(method=method))
    limit = 0.5 * np.linalg.norm(free.positions - vertices, axis=1).max()
    settings = FairingSettings(method=method, max_deviation=limit)
    steps = fair(vertices, faces, settings).steps
    for step in steps:
        assert np.linalg.norm(step.positions - vertices, axis=1).max() <= limit
    reached = np.linalg.norm(steps[-1].positions - vertices, axis=1)
    # Some come to their limit, most do not.
    assert np.count_nonzero(reached > limit * (1 - 1e-6)) >= 1
    assert np.median(reached) < 0.9 * limit


def test_a_limit_that_nothing_reaches_changes_nothing():
    mesh = noisy_ball(2, 0.05)
    free, bounded = (fair(*mesh, FairingSettings(max_deviation=m)) for m in (None, 10.0))
    assert np.array_equal(free.positions, bounded.positions)


@pytest.mark.parametrize("precision", [np.float32, np.float64])
@pytest.mark.parametrize("place", [0.0, 1.0, 1e6, 1e12])
def test_rounding_does_not_exceed_the_limit(place, precision):
    """In the precision of Blender as well."""
    generator = np.random.default_rng(2)
    start = (place + generator.normal(size=(10_000, 3))).astype(precision).astype(float)
    moved = (start + generator.normal(size=start.shape)).astype(precision)
    for limit in (0.1, 1.0, 1 / 3):
        bounded = limited(moved, start, limit)
        assert bounded.dtype == precision
        assert np.linalg.norm(bounded.astype(float) - start, axis=1).max() <= limit
