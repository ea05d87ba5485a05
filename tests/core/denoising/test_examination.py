"""Examination before a run: it finds what `denoise` finds, and counts what is there."""

import numpy as np
import pytest
from support import bad_meshes, meshes

from adaptive_fairing.core import DenoiseSettings, InputError, denoise
from adaptive_fairing.core.denoising.examination import examine
from adaptive_fairing.core.problem.diagnosis import find_problems
from adaptive_fairing.core.problem.mesh_counts import mesh_counts


@pytest.mark.parametrize("noise", [0.02, 0.05])
def test_it_finds_the_noise_that_denoise_finds(noise):
    vertices, faces = meshes.noisy_ball(4, noise)
    found, result = examine(vertices, faces), denoise(vertices, faces)
    assert found.noise_level == pytest.approx(result.noise_level, rel=1e-9)
    # Edges of the slightly smoothed surface here, of the denoised one there.
    assert found.noise_length == pytest.approx(result.noise_length, rel=0.03)
    assert found.noise_length == pytest.approx(noise, rel=0.1)
    assert result.noise_length == pytest.approx(noise, rel=0.1)
    assert not found.is_clean
    assert found.notes == result.notes == ()


@pytest.mark.parametrize("width", [1.0, 2.0, 8.0])
def test_it_heeds_the_width_that_was_told(width):
    """A model that looks clean is taken for noise of that width."""
    vertices, faces = meshes.random_hull(0, 400)
    settings = DenoiseSettings(width=width)
    found, result = examine(vertices, faces, settings), denoise(vertices, faces, settings)
    assert found.noise_level == pytest.approx(result.noise_level, rel=1e-9)
    assert not found.is_clean
    assert examine(vertices, faces).is_clean


def test_the_length_is_in_the_units_of_the_mesh():
    vertices, faces = meshes.noisy_ball(3, 0.02)
    found, of_larger = examine(vertices, faces), examine(1000 * vertices, faces)
    assert of_larger.noise_length == pytest.approx(1000 * found.noise_length, rel=1e-6)
    assert of_larger.noise_level == pytest.approx(found.noise_level, rel=1e-6)


@pytest.mark.parametrize(
    "mesh", [meshes.noisy_ball(4, 0.0), meshes.random_hull(0, 40), meshes.random_hull(0, 400)]
)
def test_what_denoise_leaves_alone_is_clean_for_the_same_reason(mesh):
    found, result = examine(*mesh), denoise(*mesh)
    assert not result.is_changed
    assert found.is_clean
    assert found.notes == result.notes
    assert found.noise_level == pytest.approx(result.noise_level, rel=1e-9, abs=1e-12)


def test_the_settings_decide_what_counts_as_noise():
    vertices, faces = meshes.random_hull(0, 400)
    assert examine(vertices, faces).is_clean
    assert not examine(vertices, faces, DenoiseSettings(clean="denoise")).is_clean


def test_it_tells_what_is_wrong_with_a_mesh():
    vertices, faces = bad_meshes.everything_wrong()
    found, expected = examine(vertices, faces), find_problems(vertices, faces)
    for mine, other in zip(vars(found.problems).values(), vars(expected).values(), strict=True):
        assert np.array_equal(mine, other)
    assert len(found.problems.vertices) > 0
    assert found.counts == mesh_counts(np.asarray(faces))


def test_nothing_that_was_handed_over_is_changed():
    vertices, faces = meshes.noisy_ball(3, 0.02)
    before = vertices.copy(), faces.copy()
    examine(vertices, faces)
    assert np.array_equal(vertices, before[0])
    assert np.array_equal(faces, before[1])


def test_it_can_be_ended_in_the_middle():
    class EndedError(Exception):
        pass

    def end(progress):
        raise EndedError

    with pytest.raises(EndedError):
        examine(*meshes.noisy_ball(2, 0.02), progress=end)


def test_coordinates_that_are_no_numbers_are_refused():
    vertices, faces = meshes.tetrahedron()
    with pytest.raises(InputError, match="finite"):
        examine(vertices * [1, 1, np.nan], faces)
