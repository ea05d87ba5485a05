"""Vertex groups as arrays of weights; one of them paints the original of a result back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import bpy
import numpy as np

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from ...core.runtime.arrays import SingleArray

PAINT_GROUP = "Fairing"
"""Vertex group whose weights say how much of the result is shown: 1 all, 0 the original."""

_weights: dict[tuple[int, int], SingleArray] = {}  # of the object that was shown last


@dataclass(frozen=True)
class GroupWeights:
    """A vertex group.

    Attributes
    ----------
    name
    is_locked
    weights
        (n,); vertices outside the group have 0.
    is_member
        (n,) 1 inside, 0 outside.
    """

    name: str
    is_locked: bool
    weights: SingleArray
    is_member: SingleArray

    def with_weights(self, refined: Callable[[SingleArray], SingleArray]) -> GroupWeights:
        """Group on another mesh; every vertex made from a member is a member."""
        return replace(self, weights=refined(self.weights), is_member=refined(self.is_member))


def read_groups(obj: bpy.types.Object) -> list[GroupWeights]:
    """Read all groups of an object in Object Mode."""
    n, n_groups = len(obj.data.vertices), len(obj.vertex_groups)
    if not n_groups:
        return []
    weights, members = np.zeros((2, n_groups, n), dtype=np.float32)
    for vertex in obj.data.vertices:
        for element in vertex.groups:
            if element.group < n_groups:
                weights[element.group, vertex.index] = element.weight
                members[element.group, vertex.index] = 1
    return [
        GroupWeights(group.name, group.lock_weight, weights[i], members[i])
        for i, group in enumerate(obj.vertex_groups)
    ]


def group_weights(obj: bpy.types.Object, group: bpy.types.VertexGroup) -> SingleArray:
    """Read the weights (n,) of one group, 0 outside of it; faster than `read_groups`."""
    n, weight_of = len(obj.data.vertices), group.weight
    with suppress(RuntimeError):  # a vertex is not in the group
        return np.fromiter(map(weight_of, range(n)), np.float32, n)
    weights = np.zeros(n, dtype=np.float32)
    for index in range(n):
        try:
            weights[index] = weight_of(index)
        except RuntimeError:
            pass
    return weights


def add_weights(group: bpy.types.VertexGroup, members: Sequence[int], weights: SingleArray) -> None:
    """Add vertices to a group with weights (k,); Blender's call takes one weight for many."""
    order = np.argsort(weights, kind="stable")
    members = np.asarray(members)[order]
    values, size = np.unique(weights, return_counts=True)
    ends = np.cumsum(size)
    for value, begin, end in zip(values.tolist(), ends - size, ends, strict=True):
        group.add(members[begin:end].tolist(), value, "REPLACE")


def same_groups(first: Sequence[GroupWeights], second: Sequence[GroupWeights]) -> bool:
    """Whether groups have the same names, locks, members and weights, in the same order."""
    return len(first) == len(second) and all(
        (a.name, a.is_locked) == (b.name, b.is_locked)
        and np.array_equal(a.weights, b.weights)
        and np.array_equal(a.is_member, b.is_member)
        for a, b in zip(first, second, strict=True)
    )


def write_groups(obj: bpy.types.Object, groups: Sequence[GroupWeights]) -> None:
    """Write groups to an object without groups; the same one is active as before."""
    active = obj.vertex_groups.active_index
    obj.vertex_groups.clear()
    for group in groups:
        new = obj.vertex_groups.new(name=group.name)
        members = np.flatnonzero(group.is_member > 0)
        add_weights(new, members, group.weights[members])
        new.lock_weight = group.is_locked
    if groups:
        obj.vertex_groups.active_index = active


def made_paint_group(obj: bpy.types.Object) -> bpy.types.VertexGroup:
    """Find or make the group of an object, and make it active; a new one shows the whole result."""
    group = obj.vertex_groups.get(PAINT_GROUP)
    if group is None:
        group = obj.vertex_groups.new(name=PAINT_GROUP)
        group.add(range(len(obj.data.vertices)), 1.0, "REPLACE")
        forget_weights()
    obj.vertex_groups.active = group
    return group


def remove_paint_group(obj: bpy.types.Object) -> None:
    """Remove the group, if there is one."""
    group = obj.vertex_groups.get(PAINT_GROUP)
    if group is not None:
        obj.vertex_groups.remove(group)


def paint_weights(obj: bpy.types.Object) -> SingleArray | None:
    """Weights (n,) of the group, 0 outside of it; None without a group."""
    group = obj.vertex_groups.get(PAINT_GROUP)
    if group is None:
        return None
    key = obj.session_uid, len(obj.data.vertices)
    if key not in _weights:
        _weights.clear()
        _weights[key] = group_weights(obj, group)
    return _weights[key]


def have_weights_changed(obj: bpy.types.Object) -> bool:
    """Read the weights of the group again, and compare them with those that were read last."""
    before = _weights.pop((obj.session_uid, len(obj.data.vertices)), None)
    now = paint_weights(obj)
    return now is not None and not (before is not None and np.array_equal(before, now))


def forget_weights() -> None:
    """Have the weights read again at the next use, because they may have been painted."""
    _weights.clear()
