"""The measuring of the claims, on tiny meshes: identities of the measures, and the command."""

from __future__ import annotations

import json

import numpy as np
import pytest

from adaptive_fairing.core import FairingSettings, TriangleTopology, fair
from adaptive_fairing.core.mesh.density import smoothed
from research.claims import __main__ as command
from research.claims import convergence, density_passes, differences, stopping, under_over_fairing
from research.claims.homogenisation import DISC_STEPS, quality
from research.claims.homogenisation import run as homogenisation
from research.claims.measures import TENSOR, TIMESTEP, UNIFORM, DensityClasses, matched_tau
from research.claims.pairs import HEAD, MeshPair
from research.claims.shapes import flat_hexagon, graded_hexagon
from research.claims.tables import Table, replace_tables, shown
from tools.geometry.noise import add_noise
from tools.geometry.triangles import density_ratio, edge_lengths, icosphere, vertex_normals


@pytest.fixture(scope="module")
def pair():
    """A sphere with edges three times longer on one side, and noise."""
    vertices, triangles = icosphere(3)
    clean = vertices * (1 + 0.2 * vertices[:, :1]) * [1.0, 1.2, 0.9]
    return MeshPair("ball", add_noise(clean, triangles, 0.15, 3), clean, triangles)


def test_classes_part_the_vertices_by_density(pair):
    classes = pair.classes
    assert np.sum(classes.fifths, axis=0).tolist() == [1] * len(pair.clean)
    longest = [classes.lengths[part].max() for part in classes.fifths]
    shortest = [classes.lengths[part].min() for part in classes.fifths]
    assert all(a >= b for a, b in zip(shortest, longest[1:], strict=False))
    sizes = [part.sum() for part in classes.fifths]
    assert max(sizes) - min(sizes) <= 1


def test_distance_counts_local_edges_along_normals_only(pair):
    classes = pair.classes
    normal = vertex_normals(pair.clean, pair.triangles)
    raised = pair.clean + 0.3 * classes.lengths[:, None] * normal
    assert classes.by_fifth(raised, pair.clean) == pytest.approx([0.3] * 5)
    slide = np.cross(normal, [0.3, 0.5, 0.7])
    assert classes.distance(pair.clean + slide, pair.clean) == pytest.approx(0.0, abs=1e-12)


def test_roughness_has_no_unit_and_is_that_of_a_raised_vertex(pair):
    everywhere = np.ones(len(pair.clean), dtype=bool)
    rough = pair.classes.roughness(pair.noisy, everywhere)
    larger = DensityClasses(5 * pair.clean, pair.triangles)
    assert larger.roughness(5 * pair.noisy, everywhere) == pytest.approx(rough)
    flat, triangles = flat_hexagon(3)
    centre = np.arange(len(flat)) == 0
    flat[0, 2] = 0.1  # the mean of the neighbours stays in the plane, the normal upright
    assert DensityClasses(flat, triangles).roughness(flat, centre) == pytest.approx(0.1, rel=0.01)


def test_matched_tau_makes_the_coarse_part_as_rough_as_the_clean_one(pair):
    tau = matched_tau(TIMESTEP, pair.noisy, pair.clean, pair.classes, 2)
    moved = TIMESTEP.faired(pair.noisy, pair.triangles, tau, 2)
    classes = pair.classes
    goal = classes.roughness(pair.clean, classes.coarse)
    assert classes.roughness(moved, classes.coarse) == pytest.approx(goal, rel=0.01)


def test_no_detail_is_lost_and_all_noise_is_left_without_diffusion(pair):
    still = MeshPair(pair.name, pair.noisy, pair.clean, pair.triangles, type(HEAD)(1e-12, 1e-12, 1))
    row = under_over_fairing._row(still, UNIFORM, 1e-12)
    noise, detail = np.array(row[3:-1]).T
    np.testing.assert_allclose(noise, pair.classes.by_fifth(pair.noisy, pair.clean), rtol=1e-6)
    np.testing.assert_allclose(detail, 0, atol=1e-6)


def test_a_scheme_does_not_differ_from_itself(pair):
    table = differences.difference_table([pair], TIMESTEP, TIMESTEP)
    assert len(table.rows) == 3
    for row in table.rows:
        assert row[table.columns.index("difference")] == 0.0


def test_least_error_is_no_greater_than_near_by(pair):
    best = differences.best_tau(pair, TIMESTEP)

    def error(tau):
        moved = TIMESTEP.faired(pair.noisy, pair.triangles, tau, pair.published.steps)
        return pair.classes.distance(moved, pair.clean)

    assert error(best) < min(error(1.4 * best), error(best / 1.4))


@pytest.mark.parametrize("bound", [0.9, 0.5, 0.3])
def test_curvature_stop_is_the_solver_s(pair, bound):
    settings = TIMESTEP.settings(0.01, 6)
    energy = stopping.energies(fair(pair.noisy, pair.triangles, settings))
    stopped = fair(pair.noisy, pair.triangles, TIMESTEP.settings(0.01, 6, stop_curvature=bound))
    expected = len(stopped.steps) if stopped.stop_reason == "curvature" else None
    assert stopping.curvature_stop(energy, bound) == expected


@pytest.mark.parametrize("bound", [40.0, 3.0, 1e-6])
def test_rate_stop_is_the_solver_s(pair, bound):
    settings = TIMESTEP.settings(0.01, 6)
    energy = stopping.energies(fair(pair.noisy, pair.triangles, settings))
    stopped = fair(pair.noisy, pair.triangles, TIMESTEP.settings(0.01, 6, stop_rate=bound))
    expected = len(stopped.steps) if stopped.stop_reason == "rate" else None
    assert stopping.rate_stop(energy, 0.01, bound) == expected


def test_three_passes_differ_from_themselves_in_nothing_and_from_others_in_something(pair):
    _, differences_of = density_passes.run([pair]).tables
    for row in differences_of.rows:
        by_passes = dict(zip(differences_of.columns[2:], row[2:], strict=True))
        assert by_passes.pop("3") == 0.0
        assert 0 < by_passes["2"] < by_passes["1"] < by_passes["0"] < 0.2
        assert by_passes["2"] < by_passes["5"] < by_passes["10"] < 0.2


def test_limit_surface_of_the_interpolating_control_points_is_the_sphere():
    vertices, triangles = icosphere(1)
    topology = TriangleTopology(triangles, len(vertices))
    control = convergence.interpolating(topology, vertices)
    limit = np.stack([smoothed(topology, column, 1) for column in control.T], axis=1)
    np.testing.assert_allclose(limit, vertices, atol=1e-12)


def test_orders_of_errors_that_fall_with_the_square():
    assert convergence.orders([1.0, 0.25, 0.0625]) == [None, 2.0, 2.0]


def test_quality_of_known_triangles():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0.5, 0.75**0.5, 0), (0, 1, 0), (2, 0, 0)])
    values = quality(vertices, np.array([(0, 1, 2), (0, 1, 3), (0, 1, 4)]))
    right_angle = 2 * (1 - 0.5**0.5) / 0.5**0.5  # inscribed 1 - 1/√2, circumscribed 1/√2
    np.testing.assert_allclose(values, [1.0, right_angle, 0.0], atol=1e-12)


def test_on_a_plane_only_the_tensor_moves_vertices_and_it_evens_them_out():
    """Δx = 0 there, and div(D ∇x) = ∇D points from dense to coarse."""
    (table,) = homogenisation([]).tables
    growth, ratio, move = (np.array(column) for column in list(zip(*table.rows, strict=True))[1:])
    count = len(DISC_STEPS)
    assert (move[: 2 * count] < 1e-6).all()
    np.testing.assert_allclose(growth[: 2 * count], 1, atol=1e-4)
    assert (np.diff([1.0, *growth[2 * count :]]) > 0.1).all()
    before = density_ratio(*graded_hexagon(12, 15.0))
    assert (np.diff([before, *ratio[2 * count :]]) < 0).all()


def test_schemes_of_the_claims_reach_the_solver():
    assert TENSOR.settings(0.5, 3, density_passes=1) == FairingSettings(
        method="adaptive_tensor", density="edge_length", tau=0.5, steps=3, density_passes=1
    )


def test_density_ratio_of_the_graded_hexagon_grows_as_asked():
    vertices, triangles = graded_hexagon(20, 8.0)
    lengths = edge_lengths(vertices, triangles)
    assert lengths.max() / lengths.min() == pytest.approx(8.0, rel=0.05)


@pytest.mark.parametrize(
    ("cell", "text"),
    [
        (None, "–"), ("name", "name"), (12, "12"), (0.0, "0"), (0.1234, "0.123"), (123.4, "123"),
        (0.0202, "0.020"), (2.04e-7, "2.0e-07"), (9999.0, "9999"), (14321.0, "1.4e+04"),
        ((0.5, 1.25), "0.500 / 1.25"),
    ],
)  # fmt: skip
def test_cells(cell, text):
    assert shown(cell) == text


def test_tables_replace_their_own_place_in_a_page_only(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "Text\n<!-- tables: one -->\nold\n<!-- end -->\n<!-- tables: two -->\nkept\n<!-- end -->\n"
    )
    replace_tables(page, "one", [Table("T", ("a", "b"), [["x", 0.5]])])
    text = page.read_text()
    assert "old" not in text and "kept" in text
    assert "**T**\n\n| a | b |\n| --- | ---: |\n| x | 0.500 |\n" in text
    with pytest.raises(ValueError, match="0 places"):
        replace_tables(page, "three", [])


def test_every_claim_has_its_place_in_the_page():
    text = command.PAGE.read_text(encoding="utf-8")
    for name in command.CLAIMS:
        assert text.count(f"<!-- tables: {name} -->\n") == 1
        assert f"python -m research.claims {name}" in text


def test_the_command_prints_the_same_numbers_as_json(pair, monkeypatch, capsys):
    monkeypatch.setattr(command, "_pairs", lambda options: [pair])
    assert command.main(["homogenisation", "--json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)
    tables = homogenisation([pair]).tables
    assert record["claim"] == "homogenisation"
    assert [table["title"] for table in record["tables"]] == [table.title for table in tables]
    assert [list(row.values()) for row in record["tables"][1]["rows"]] == tables[1].rows


def test_meshes_that_are_no_pair_are_refused(tmp_path, capsys):
    pytest.importorskip("bpy")
    assets = command.ROOT / "assets"
    pair = [str(assets / "head_noisy.ply"), str(assets / "foot.ply")]
    assert command.main(["homogenisation", "--pair", *pair]) == 1
    assert "are no pair" in capsys.readouterr().err


def test_a_pair_of_files_keeps_the_order_of_its_vertices():
    pytest.importorskip("bpy")
    from research.claims.pairs import file_pair, sample_pair

    assets = command.ROOT / "assets"
    read = file_pair(assets / "foot_noisy.ply", assets / "foot.ply")
    foot = sample_pair("foot")
    np.testing.assert_array_equal(read.triangles, foot.triangles)
    np.testing.assert_array_equal(read.clean, foot.clean)
    np.testing.assert_array_equal(read.noisy, foot.noisy)
