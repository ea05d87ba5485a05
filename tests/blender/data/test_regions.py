"""Regions of the smoothing: selection, mask, vertex group."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere, noisy_ball
from support.objects import add_object, key_positions, select, shown_positions

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.core import FairingSettings, fair

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def sphere():
    vertices, faces = icosphere(2)
    vertices = vertices + np.random.default_rng(1).normal(0.0, 0.02, vertices.shape)
    obj = add_object(vertices, faces)
    obj.select_set(True)
    return obj


def upper(obj):
    """Return which vertices lie in the upper half."""
    return read_positions(obj.data)[:, 2] > 0


def expected(obj, weights):
    """Fair the object with weights, in the core."""
    data = read_mesh(obj.data)
    result = fair(data.vertices, data.triangles, FairingSettings(steps=2), weights=weights)
    return result.positions.astype(np.float32)


def enter(mode):
    assert bpy.ops.object.mode_set(mode=mode) == {"FINISHED"}


class TestEditMode:
    def test_only_the_selected_vertices_move(self, sphere):
        chosen = upper(sphere)
        positions = expected(sphere, chosen.astype(float))
        before = read_positions(sphere.data)
        select(sphere, chosen)
        enter("EDIT")
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2)
        assert sphere.mode == "EDIT"
        enter("OBJECT")
        found = key_positions(sphere, "Fairing 2")
        assert np.array_equal(found, positions)
        assert np.array_equal(found[~chosen], before[~chosen])
        assert (found[chosen] != before[chosen]).any(axis=1).all()

    @pytest.mark.parametrize("use_region", [True, False])
    def test_without_a_selection_or_with_the_option_off_everything_moves(self, sphere, use_region):
        positions = expected(sphere, None)
        select(sphere, np.zeros(len(sphere.data.vertices), bool) if use_region else upper(sphere))
        enter("EDIT")
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2, use_region=use_region)
        enter("OBJECT")
        assert np.array_equal(key_positions(sphere, "Fairing 2"), positions)

    def test_the_selection_counts_in_edit_mode_only(self, sphere):
        positions = expected(sphere, None)
        select(sphere, upper(sphere))
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2)
        assert np.array_equal(key_positions(sphere, "Fairing 2"), positions)

    def test_what_was_edited_before_the_run_counts(self, sphere):
        enter("EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.transform.resize(value=(2.0, 2.0, 2.0))
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2)
        enter("OBJECT")
        assert np.ptp(key_positions(sphere, "Basis")[:, 0]) > 3.9
        assert np.array_equal(key_positions(sphere, "Fairing 2"), expected(sphere, None))

    def test_all_objects_in_the_mode_are_faired(self, sphere):
        second = add_object(*icosphere(1), name="Second")
        second.select_set(True)
        sphere.select_set(True)
        enter("EDIT")
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
        assert {sphere.mode, second.mode} == {"EDIT"}
        enter("OBJECT")
        for obj in (sphere, second):
            assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Fairing 1"]


class TestSculptMode:
    def mask(self, obj, values):
        attribute = obj.data.attributes.new(".sculpt_mask", "FLOAT", "POINT")
        attribute.data.foreach_set("value", np.asarray(values, dtype=np.float32))

    def test_the_mask_spares_by_its_strength(self, sphere):
        mask = np.clip(read_positions(sphere.data)[:, 2], 0.0, 1.0).astype(np.float32)
        positions = expected(sphere, 1.0 - mask.astype(np.float64))
        self.mask(sphere, mask)
        enter("SCULPT")
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2)
        assert sphere.mode == "SCULPT"
        enter("OBJECT")
        assert np.array_equal(key_positions(sphere, "Fairing 2"), positions)

    def test_the_mask_counts_in_sculpt_mode_only(self, sphere):
        positions = expected(sphere, None)
        self.mask(sphere, np.ones(len(sphere.data.vertices)))
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2)
        assert np.array_equal(key_positions(sphere, "Fairing 2"), positions)

    def test_a_mask_over_everything_is_refused(self, sphere):
        self.mask(sphere, np.ones(len(sphere.data.vertices)))
        enter("SCULPT")
        with pytest.raises(RuntimeError, match="leave no vertex to smooth"):
            bpy.ops.object.adaptive_fairing(algorithm="FAIR")
        assert sphere.mode == "SCULPT"

    def test_a_multiresolution_sculpture_is_refused(self, sphere):
        sphere.modifiers.new("Multires", "MULTIRES")
        enter("SCULPT")
        with pytest.raises(RuntimeError, match="Leave Sculpt Mode"):
            bpy.ops.object.adaptive_fairing(algorithm="FAIR")


class TestVertexGroup:
    @pytest.mark.parametrize("invert", [False, True])
    def test_weights_scale_the_smoothing(self, sphere, invert):
        group = sphere.vertex_groups.new(name="Half")
        weights = np.zeros(len(sphere.data.vertices))
        for vertex in np.flatnonzero(upper(sphere)):
            weights[vertex] = np.float32(0.25 + 0.5 * (vertex % 2))
            group.add([int(vertex)], weights[vertex], "REPLACE")
        positions = expected(sphere, 1.0 - weights if invert else weights)
        bpy.ops.object.adaptive_fairing(
            algorithm="FAIR", steps=2, vertex_group="Half", invert_vertex_group=invert
        )
        assert np.array_equal(key_positions(sphere, "Fairing 2"), positions)

    def test_it_limits_the_selection_further(self, sphere):
        chosen = upper(sphere)
        group = sphere.vertex_groups.new(name="Some")
        group.add(list(range(0, len(chosen), 2)), 1.0, "REPLACE")
        both = chosen & (np.arange(len(chosen)) % 2 == 0)
        positions = expected(sphere, both.astype(float))
        select(sphere, chosen)
        enter("EDIT")
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2, vertex_group="Some")
        enter("OBJECT")
        assert np.array_equal(key_positions(sphere, "Fairing 2"), positions)

    def test_an_empty_group_is_refused(self, sphere):
        sphere.vertex_groups.new(name="Empty")
        with pytest.raises(RuntimeError, match="leave no vertex to smooth"):
            bpy.ops.object.adaptive_fairing(algorithm="FAIR", vertex_group="Empty")


class TestSharpEdges:
    @pytest.mark.parametrize("algorithm", ["FAIR", "DENOISE"])
    def test_vertices_of_marked_edges_are_held_on_request(self, algorithm):
        obj = add_object(*noisy_ball(4, 0.02))
        obj.select_set(True)
        before = read_positions(obj.data).astype(np.float32)
        marked = np.arange(0, len(obj.data.edges), 50)
        held = np.zeros(len(before), dtype=bool)
        for edge in marked.tolist():
            obj.data.edges[edge].use_edge_sharp = True
            held[list(obj.data.edges[edge].vertices)] = True
        for hold_sharp in (True, False):
            bpy.ops.object.adaptive_fairing(algorithm=algorithm, hold_sharp=hold_sharp)
            stays = (shown_positions(obj) == before).all(axis=1)
            assert np.array_equal(stays, held) if hold_sharp else not stays[held].any()
            bpy.ops.object.adaptive_fairing_discard()

    def test_without_marked_edges_nothing_is_held(self, sphere):
        positions = expected(sphere, None)
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2, hold_sharp=True)
        assert np.array_equal(key_positions(sphere, "Fairing 2"), positions)
