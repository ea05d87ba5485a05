"""Results that come late: the object may be gone or changed by then."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.jobs.fairing_task import FairingTask, run_tasks
from adaptive_fairing.blender.jobs.store_result import store_task
from adaptive_fairing.core import FairingError, FairingSettings

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def task():
    obj = add_object(*icosphere(1))
    data = read_mesh(obj.data)
    task = FairingTask(obj.name, data.vertices, data.triangles, None, FairingSettings(steps=2))
    list(run_tasks([task]))
    return task


def store(task):
    return store_task(task, output="ABSOLUTE_KEYS", store_density=True)


def test_a_deleted_object_is_said(task):
    bpy.data.objects.remove(bpy.data.objects["Thing"])
    with pytest.raises(FairingError, match="deleted or renamed during the run"):
        store(task)


def test_another_object_of_the_same_name_is_left_alone(task):
    bpy.data.objects.remove(bpy.data.objects["Thing"])
    other = add_object(*icosphere(2))
    assert other.name == "Thing"
    with pytest.raises(FairingError, match="the mesh was changed during the run"):
        store(task)
    assert other.data.shape_keys is None


def test_a_mesh_that_was_edited_is_left_alone(task):
    obj = bpy.data.objects["Thing"]
    obj.data.vertices[3].co.x += 0.5
    before = read_positions(obj.data)
    with pytest.raises(FairingError, match="the mesh was changed during the run"):
        store(task)
    assert np.array_equal(read_positions(obj.data), before)
    assert obj.data.shape_keys is None
    assert len(obj.adaptive_fairing.steps) == 0


def test_a_stopped_run_is_marked_as_such(task):
    del task.steps[1]
    obj = store(task)
    assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Fairing 1"]
    assert obj.adaptive_fairing.stop_reason == "stopped"


def test_an_evolution_slides_from_the_basis_to_the_last_step(task):
    obj = store(task)
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
