"""Boolean models and decimated shapes that harm is measured on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from research.denoising import harm
from research.denoising.walls import periodic_wall
from tools.geometry.ply import read_ply

ASSETS = Path(__file__).resolve().parents[2] / "assets"


def test_a_seed_makes_one_model():
    one, other, third = (harm.boolean_model(np.random.default_rng(seed)) for seed in (3, 3, 4))
    assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
    assert len(one[0]) != len(third[0]) or not np.array_equal(one[0], third[0])


def test_the_largest_move_is_a_part_of_the_diagonal(monkeypatch):
    vertices, faces = harm.boolean_model(np.random.default_rng(3))
    size = harm.diagonal(vertices)

    class Moved:
        positions = vertices + np.eye(len(vertices), 3) * 0.02 * size

    monkeypatch.setattr(harm, "denoise", lambda *_: Moved)
    assert harm.largest_move(vertices, faces) == pytest.approx(0.02)


@pytest.mark.parametrize(
    "wall", [("gyroid", 32, 1.5, 1.2), ("primitive", 32, 1.5, 0.7), ("diamond", 32, 1, 1.2)]
)
def test_bends_of_a_thin_wall_are_no_noise_on_flat_faces(wall):
    """With noise of 0.02 these walls ended at 5.3 to 6.9 times it."""
    vertices, faces = periodic_wall(*wall)
    assert np.linalg.det(vertices[faces]).sum() > 0
    assert harm.largest_move(vertices, faces) == 0
    (run,) = harm.wall_runs([wall], [0.02])
    assert run[1] < 1.1


def test_decimated_shapes_come_with_every_noise():
    vertices, faces = read_ply(ASSETS / "head.ply")
    runs = dict(harm.decimated_runs([("head", vertices, faces)]))
    assert len(runs) == len(harm.NOISES)
    assert runs["head normal 0.4"] < 1
