"""Each solve starts from what the last steps did: fewer iterations, and no larger errors."""

import numpy as np
from support import meshes

from adaptive_fairing.core import FairingSettings, fair
from adaptive_fairing.core.linalg.successive_solves import SuccessiveSolves


def test_they_save_iterations_and_errors(monkeypatch):
    vertices, faces = meshes.random_closed(0, meshes.icosphere(3))

    def steps(**settings):
        return fair(vertices, faces, FairingSettings(tau=0.004, steps=6, **settings)).steps

    exact, from_last_steps = steps(cg_tolerance=1e-12), steps()
    monkeypatch.setattr(SuccessiveSolves, "start", lambda _, right_side: np.zeros_like(right_side))
    from_zero = steps()

    saved, errors = [], []
    for own, other, best in zip(from_last_steps, from_zero, exact, strict=True):
        saved.append(other.solve.iterations - own.solve.iterations)
        errors.append([np.linalg.norm(each.positions - best.positions) for each in (own, other)])
    assert saved[0] == 0
    assert min(saved[2:]) >= 4
    assert all(own < other for own, other in errors[1:])
