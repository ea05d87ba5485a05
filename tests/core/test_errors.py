"""Errors: one line that names the field, or says how many are wrong, and which."""

from dataclasses import FrozenInstanceError, fields

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import (
    DenoiseSettings,
    FairingError,
    FairingSettings,
    InputError,
    SettingsError,
    TopologyError,
    TriangleTopology,
    fair,
    fair_steps,
)

BAD_FAIRING = {
    "method": ["fast", "", None, 3],
    "tau": [0, -0.1, float("nan"), float("inf"), "0.1", True],
    "radius": [0, -1, float("nan"), float("inf"), "1", None, True],
    "steps": [0, -1, 2.0, "4", None, True],
    "density": ["edges", None],
    "density_passes": [-1, 1.5, None, 10**9],
    "boundary": ["open", None],
    "keep_volume": [None, 1, "yes"],
    "max_deviation": [0, -1, float("nan"), "x"],
    "stop_curvature": [0, -1, float("nan"), "x"],
    "stop_rate": [0, -1, float("nan"), "x"],
    "cg_tolerance": [0, -1, 1, 2, float("nan"), None],
    "cg_max_iterations": [0, -5, 1.5, None],
    "quadrature_tolerance": [0, -1, 2, float("nan"), None],
    "normalize": [None, True, 0, 1, "cube"],
}
BAD_DENOISING = {
    "strength": [0, -1, 100, float("nan"), "1", None, True],
    "features": ["round", "", None],
    "boundary": ["open", None],
    "clean": ["yes", True, None],
    "width": [0, 0.5, 16.5, -1, float("nan"), "wide", "4", None, True],
    "max_deviation": [0, -1, float("nan"), "x"],
}
BAD_SETTINGS = {FairingSettings: BAD_FAIRING, DenoiseSettings: BAD_DENOISING}


@pytest.mark.parametrize(
    ("settings", "field", "value"),
    [
        (settings, field, value)
        for settings, bad in BAD_SETTINGS.items()
        for field, values in bad.items()
        for value in values
    ],
)
def test_bad_setting_is_refused_by_the_name_of_its_field(settings, field, value):
    with pytest.raises(SettingsError, match=rf"^{field} must be .*not ") as caught:
        settings(**{field: value})
    assert "\n" not in str(caught.value)


def test_numbers_of_numpy_are_settings_and_become_pythons_own():
    settings = FairingSettings(
        steps=np.int64(4), tau=np.float32(0.5), radius=np.float64(2), density_passes=np.uint8(3)
    )
    assert settings == FairingSettings(tau=0.5, radius=2.0, steps=4, density_passes=3)
    kinds = [type(getattr(settings, name)) for name in ("steps", "tau", "radius")]
    assert kinds == [int, float, float]


@pytest.mark.parametrize("run", [fair, fair_steps])
@pytest.mark.parametrize("settings", [{}, {"steps": 2}, "uniform", DenoiseSettings()])
def test_settings_of_another_type_are_refused(run, settings):
    with pytest.raises(SettingsError, match=r"settings must be FairingSettings\(…\), not"):
        run(*meshes.octahedron(), settings)


def test_unsupported_quadrature_tolerance_is_refused_by_name():
    with pytest.raises(SettingsError, match="quadrature_tolerance"):
        fair(*meshes.octahedron(), FairingSettings(quadrature_tolerance=1e-12))


def test_settings_are_frozen_and_every_field_is_checked():
    for settings, bad in BAD_SETTINGS.items():
        assert set(bad) == {field.name for field in fields(settings)}
        with pytest.raises(FrozenInstanceError):
            settings().boundary = "free"


def test_all_errors_have_one_base():
    for error in (SettingsError, InputError, TopologyError):
        assert issubclass(error, FairingError)


# Arrays ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v, f: ([[0, 0, 0], [1, 0]], f), "vertices must be an array of numbers: .+"),
        (lambda v, f: (v.astype(str), f), "vertices must be an array of numbers, not of <U"),
        (lambda v, f: (v * 1j, f), "vertices must be an array of numbers, not of complex128"),
        (lambda v, f: (np.ma.masked_less(v, -0.5), f), "3 rows of vertices are masked: "),
        (lambda v, f: (v, [*f.tolist(), [0, 1]]), "faces must be an array of numbers: .+"),
        (lambda v, f: (v, f.astype(str)), "faces must be an array of numbers, not of <U"),
        (lambda v, f: (v, np.ma.masked_equal(f, 0)), "4 rows of faces are masked: "),
        (lambda v, f: (v[:, :2], f), r"vertices must have shape \(n, 3\), not \(6, 2\)"),
        (lambda v, f: (v.ravel(), f), r"vertices must have shape \(n, 3\), not \(18,\)"),
        (lambda v, f: (v, f[:, :2]), r"faces must have shape \(m, 3\), not \(8, 2\)"),
        (lambda v, f: (v, f + 0.5), "faces must be integers, not float64"),
        (lambda v, f: (v, f + 1), r"4 triangles .*outside 0 … 5"),
        (lambda v, f: (v, f - 1), r"4 triangles .*outside 0 … 5"),
        (lambda v, f: (v, f[:0]), "no triangles"),
    ],
)
def test_arrays_that_are_no_mesh_are_refused_at_the_call(change, message):
    """Before the first step is asked for, so that the caller's own line is in the traceback."""
    with pytest.raises(InputError, match=message):
        fair_steps(*change(*meshes.octahedron()))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_coordinates_that_are_not_finite_are_counted_and_listed(bad):
    vertices, faces = meshes.icosphere(1)
    vertices[[3, 17], [0, 2]] = bad
    with pytest.raises(InputError, match=r"^2 vertices .*: 3, 17"):
        fair_steps(vertices, faces)


def test_long_lists_are_cut_but_counted():
    vertices, faces = meshes.icosphere(1)
    vertices[10:30] = np.nan
    with pytest.raises(InputError, match=r"^20 vertices .*: 10, 11, 12, 13, 14, … \(20 in all\)"):
        fair_steps(vertices, faces)


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        (np.ones(5), r"weights must have shape \(6,\), not \(5,\)"),
        (np.ones((6, 1)), r"weights must have shape \(6,\), not \(6, 1\)"),
        ([1, 1, 1.5, 1, 1, -0.1], r"2 weights lie outside \[0, 1\]: at vertices 2, 5"),
        ([1, np.nan, 1, 1, 1, 1], r"1 weights lie outside \[0, 1\]: at vertices 1"),
    ],
)
def test_weights_out_of_shape_or_range_are_refused(weights, message):
    with pytest.raises(InputError, match=message):
        fair_steps(*meshes.octahedron(), weights=weights)


# Topology ----------------------------------------------------------------------------------------


def topology_error(faces, n_vertices):
    with pytest.raises(TopologyError) as caught:
        TriangleTopology(np.asarray(faces), n_vertices)
    assert "\n" not in str(caught.value)
    return caught.value


def test_triangle_with_a_repeated_vertex():
    error = topology_error([(0, 1, 2), (2, 1, 1), (1, 3, 2)], 4)
    assert str(error).startswith("1 triangles")
    assert error.triangles.tolist() == [1]


def test_edge_with_three_triangles():
    error = topology_error([(0, 1, 2), (1, 0, 3), (0, 1, 4)], 5)
    assert "1 " in str(error) and "(0, 1)" in str(error)
    assert error.edges.tolist() == [[0, 1]]


def test_neighbours_of_opposite_orientation():
    vertices, faces = meshes.icosphere(1)
    faces[7] = faces[7][::-1]
    error = topology_error(faces, len(vertices))
    assert "3 " in str(error)
    expected = sorted(sorted(pair) for pair in zip(faces[7], np.roll(faces[7], 1), strict=True))
    assert sorted(sorted(edge) for edge in error.edges.tolist()) == expected


def test_fans_that_touch_in_one_vertex():
    _, faces = meshes.merged(meshes.octahedron(), meshes.octahedron())
    faces[faces == 9] = 2
    error = topology_error(faces, 12)
    assert str(error).startswith("1 non-manifold vertices")
    assert error.vertices.tolist() == [2]


def test_two_triangles_back_to_back():
    error = topology_error([(0, 1, 2), (2, 1, 0)], 3)
    assert error.vertices.tolist() == [0, 1, 2]


def test_same_triangle_twice():
    vertices, faces = meshes.octahedron()
    error = topology_error(np.vstack([faces, faces[:1]]), len(vertices))
    assert {tuple(sorted(edge)) for edge in error.edges.tolist()} == {
        tuple(sorted(pair)) for pair in zip(faces[0], np.roll(faces[0], 1), strict=True)
    }


def test_boundary_and_closedness():
    _, faces = meshes.bumpy_disc(0)
    topology = TriangleTopology(faces, int(faces.max()) + 1)
    np.testing.assert_array_equal(topology.boundary_vertices, meshes.boundary_vertices(faces))
    assert not topology.is_closed
    assert topology.n_triangles == len(faces)
    closed = TriangleTopology(meshes.octahedron()[1], 6)
    assert closed.is_closed
    assert len(closed.boundary_vertices) == 0
