"""Results that come late: the object may be gone or changed by then."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.jobs.solve import Solve
from adaptive_fairing.blender.jobs.write_back import find_object, store_solve
from adaptive_fairing.core import FairingError, FairingSettings

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def solve():
    obj = add_object(*icosphere(1))
    data = read_mesh(obj.data)
    settings, uid = FairingSettings(steps=2), obj.session_uid
    solve = Solve(data.vertices, data.triangles, settings, name=obj.name, session_uid=uid)
    list(solve.run())
    return solve


def store(solve):
    source = find_object(solve)
    return store_solve(solve, source, way="ABSOLUTE_KEYS", store_density=True)


def test_a_deleted_object_is_said(solve):
    bpy.data.objects.remove(bpy.data.objects["Thing"])
    with pytest.raises(FairingError, match="deleted during the run"):
        store(solve)


def test_another_object_of_the_same_name_is_left_alone(solve):
    bpy.data.objects.remove(bpy.data.objects["Thing"])
    other = add_object(*icosphere(2))
    assert other.name == "Thing"
    with pytest.raises(FairingError, match="deleted during the run"):
        store(solve)
    assert other.data.shape_keys is None


def test_an_object_that_was_renamed_is_found(solve):
    bpy.data.objects["Thing"].name = "Other"
    assert store(solve).name == "Other"


def test_a_mesh_that_was_edited_is_left_alone(solve):
    obj = bpy.data.objects["Thing"]
    obj.data.vertices[3].co.x += 0.5
    before = read_positions(obj.data)
    with pytest.raises(FairingError, match="the mesh was changed during the run"):
        store(solve)
    assert np.array_equal(read_positions(obj.data), before)
    assert obj.data.shape_keys is None
    assert len(obj.adaptive_fairing.shapes) == 0


def test_a_stopped_run_is_marked_as_such(solve):
    del solve.steps[1]
    obj = store(solve)
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Fairing 1"]
    assert obj.adaptive_fairing.stop_reason == "stopped"


def test_an_evolution_slides_from_the_basis_to_the_last_step(solve):
    obj = store(solve)
    keys = obj.data.shape_keys
    record = obj.adaptive_fairing
    record.evolution = 0.0
    assert keys.eval_time == 0.0
    record.evolution = 0.5
    assert keys.eval_time == pytest.approx(keys.key_blocks["Fairing 1"].frame)
    keys.eval_time = 1000.0
    assert record.evolution == 1.0


def test_evolution_without_keys_is_zero_and_stays_so():
    obj = add_object(*icosphere(0))
    obj.adaptive_fairing.evolution = 0.7
    assert obj.adaptive_fairing.evolution == 0.0
