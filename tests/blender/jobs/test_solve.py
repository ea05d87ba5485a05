"""Positions of the steps that a solve keeps, in the precision of Blender."""

import numpy as np
import pytest
from support.meshes import noisy_ball

from adaptive_fairing.blender.jobs.solve import Solve
from adaptive_fairing.core import FairingSettings


@pytest.mark.parametrize("place", [0.0, 100.0])
def test_rounded_positions_are_no_further_than_the_limit(place):
    vertices, faces = noisy_ball(3, 0.05)
    vertices = (vertices + place).astype(np.float32).astype(np.float64)
    limit = 0.01
    solve = Solve(vertices, faces, FairingSettings(steps=2, max_deviation=limit))
    for _ in solve.run():
        assert solve.positions.dtype == np.float32
        distance = np.linalg.norm(solve.positions.astype(np.float64) - vertices, axis=1)
        assert limit * (1 - 1e-2) < distance.max() <= limit
