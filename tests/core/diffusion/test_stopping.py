"""Ends of a run: its last step, the paper's two rules, a solve that fails."""

import numpy as np
from support import meshes

from adaptive_fairing.core import FairingSettings, fair, fair_steps


def reasons(steps):
    return [step.stop_reason for step in steps]


def test_run_ends_with_its_last_step():
    result = fair(*meshes.noisy_ball(2, 0.03), FairingSettings(steps=3))
    assert reasons(result.steps) == [None, None, "steps"]
    assert result.stop_reason == "steps"


def test_run_stops_at_the_curvature_threshold():
    """(3.11): H(t) <= epsilon_2."""
    mesh = meshes.noisy_ball(2, 0.03)
    ratios = [step.curvature_ratio for step in fair_steps(*mesh, FairingSettings(steps=5))]
    assert 1 > ratios[0] > ratios[1] > ratios[2] > ratios[3]
    for threshold in (ratios[2], (ratios[1] + ratios[2]) / 2):
        result = fair(*mesh, FairingSettings(steps=5, stop_curvature=threshold))
        assert reasons(result.steps) == [None, None, "curvature"]
        assert result.stop_reason == "curvature"


def test_run_stops_at_the_rate_threshold():
    """(3.10): |H'(t)| <= epsilon_1, by divided differences over a step tau."""
    mesh = meshes.noisy_ball(2, 0.03)
    tau = 0.01
    ratios = [1.0]
    ratios += [
        step.curvature_ratio for step in fair_steps(*mesh, FairingSettings(tau=tau, steps=5))
    ]
    rates = np.abs(np.diff(ratios)) / tau
    assert (np.diff(rates) < 0).all()
    for threshold in (1.001 * rates[1], (rates[0] + rates[1]) / 2):
        result = fair(*mesh, FairingSettings(tau=tau, steps=5, stop_rate=threshold))
        assert reasons(result.steps) == [None, "rate"]


def test_run_stops_when_the_solve_does_not_converge():
    settings = FairingSettings(steps=4, cg_max_iterations=1, cg_tolerance=1e-12)
    result = fair(*meshes.noisy_ball(2, 0.03), settings)
    assert reasons(result.steps) == ["not_converged"]
    [step] = result.steps
    assert not step.solve.converged
    assert step.solve.iterations == 1
    assert step.solve.residual > 1e-12
