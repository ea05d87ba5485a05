"""Write what a run computed into Blender's data: shape keys, attributes, the record."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from ...core import FairingError, FairingStep
from ...core.results import chosen_step
from ..data.attributes import write_density
from ..data.coloring import color_by_field
from ..data.mesh_arrays import read_positions
from ..data.rollback import written_or_restored
from ..data.shape_keys import write_absolute_keys, write_final_shape, write_relative_keys
from .fairing_task import FairingTask


def store_task(task: FairingTask, *, output: str, store_density: bool) -> bpy.types.Object:
    """Write the finished steps of a task, of which there must be one at least.

    Parameters
    ----------
    task
        A task that has been run.
    output
        Identifier of `OutputProperties.output`.
    store_density
        Whether to store the density of the last step as attributes.

    Returns
    -------
    bpy.types.Object
        The object that has the result: the one that was read, or a copy of it.

    Raises
    ------
    FairingError
        The object is gone, or its mesh has been changed since it was read.
    """
    with written_or_restored(find_object(task)) as obj:
        write_steps(obj, task, output=output, store_density=store_density)
    return obj


def write_steps(
    obj: bpy.types.Object, task: FairingTask, *, output: str, store_density: bool
) -> None:
    """Write the steps to an object that may be written: shape, density and record.

    An object that is coloured by a field is coloured anew.

    Parameters: as in `store_task`; the object has the vertices of the task.
    """
    positions = [step.positions for step in task.steps]
    chosen = chosen_step(task.steps)
    if output == "FINAL_SHAPE":
        write_final_shape(obj, chosen.positions)
    elif output == "RELATIVE_KEYS":
        write_relative_keys(obj, positions, chosen.index - 1)
    else:
        write_absolute_keys(obj, positions, chosen.index - 1)
    if store_density:
        write_density(obj.data, chosen.density)
    _write_record(obj, task)
    if obj.adaptive_fairing.view:
        color_by_field(obj, obj.adaptive_fairing.view, task.settings, task.vertices)


def find_object(task: FairingTask) -> bpy.types.Object:
    """Find the object of a task again, in Object Mode and as it was when it was read.

    Raises
    ------
    FairingError
        As `store_task`.
    """
    obj = bpy.data.objects.get((task.name, task.library))
    if obj is None or obj.type != "MESH":
        raise FairingError(rpt_("the object was deleted or renamed during the run"))
    now = read_positions(obj.data)
    if now.shape != task.vertices.shape or not np.array_equal(now, task.vertices):
        raise FairingError(rpt_("the mesh was changed during the run; nothing was written"))
    return obj


def _write_record(obj: bpy.types.Object, task: FairingTask) -> None:
    record = obj.adaptive_fairing
    record.method = task.settings.method
    record.tau = task.settings.tau
    record.stop_reason = task.steps[-1].stop_reason or "stopped"
    record.seconds = task.seconds
    record.notes = "\n".join(task.steps[-1].notes)
    chosen = chosen_step(task.steps)
    record.chosen = chosen.index
    if chosen.auto is not None:
        record.noise = chosen.auto.noise
        record.noise_length = chosen.auto.noise_length
        record.radius = chosen.auto.radius
        record.is_sharp = chosen.auto.is_sharp
    record.steps.clear()
    for measures in (chosen.initial, *task.steps):
        item = record.steps.add()
        item.curvature_energy = measures.curvature_energy
        item.area = measures.area
        item.volume = measures.volume
    for step, item in zip(task.steps, record.steps[1:], strict=True):
        item.iterations = step.solve.iterations
        item.displacement = _largest_move(task, step)
        item.strength = step.auto.strength if step.auto is not None else 0.0


def _largest_move(task: FairingTask, step: FairingStep) -> float:
    return float(np.linalg.norm(step.positions - task.vertices, axis=1).max())
