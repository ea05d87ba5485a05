"""What the frames of one surface have in common: the analysis of its topology, and the strength."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from ..core import FairingError, FairingSettings, PreparedMesh, fair
from .files import import_mesh
from .frames import object_at_frame
from .job import solved_surface
from .mesh_data import MeshData, read_mesh
from .run import FairingTask, run_tasks

Place = tuple[Path, int | None]
"""A file, and a frame in it; None for the mesh as it is stored."""


class Preparations:
    """Preparations of surfaces, of which that of a sequence's first frame is kept.

    A frame with other triangles than the first is analysed on its own. So the result of a frame
    does not depend on which others were faired before it in the same process.
    """

    def __init__(self) -> None:
        self._place: Place | None = None
        self._kept: PreparedMesh | None = None

    def turn_to(
        self,
        reference: Place | None,
        object_name: str | None,
        settings: FairingSettings,
        *,
        scale: float | None,
        keep_axes: bool,
    ) -> None:
        """Make sure that the kept preparation is that of a place; None keeps nothing.

        All parameters but the place must be those of the last call with the same place.

        Raises
        ------
        FairingError, OSError
            The place cannot be read, or holds no mesh to fair.
        """
        if reference == self._place:
            return
        self._place, self._kept = reference, None
        if reference is not None:
            data = read_place(reference, object_name, keep_axes=keep_axes)
            self._kept = PreparedMesh(data.vertices, data.triangles, settings, scale=scale)

    def of(self, data: MeshData, settings: FairingSettings, scale: float | None) -> PreparedMesh:
        """Give the kept preparation if it is one of this surface, otherwise a new one."""
        kept = self._kept
        if kept is not None and kept.serves(data.triangles, len(data.vertices)):
            return kept
        return PreparedMesh(data.vertices, data.triangles, settings, scale=scale)


def read_place(place: Place, object_name: str | None, *, keep_axes: bool = False) -> MeshData:
    """Read the surface of a frame, as a job would solve on it. Replaces what Blender holds."""
    path, frame = place
    obj = import_mesh(path, object_name, keep_axes=keep_axes)
    if frame is not None:
        obj = object_at_frame(obj, frame)
    surface, _ = solved_surface(read_mesh(obj.data), path)
    return surface


def same_strength(data: MeshData, settings: FairingSettings) -> tuple[FairingSettings, float]:
    """Find what gives every frame the same smoothing as the first.

    Parameters
    ----------
    data
        Surface of the first frame.
    settings
        As asked for. A stopping rule would end frames after different numbers of steps: what it
        says of the first frame holds for all.

    Returns
    -------
    FairingSettings
        Without anything that each frame would choose for itself.
    float
        Scale into the solver's frame, see `PreparedMesh`.
    """
    prepared = PreparedMesh(data.vertices, data.triangles, settings)
    if settings.stop_curvature is not None or settings.stop_rate is not None:
        result = fair(data.vertices, data.triangles, settings, prepared=prepared)
        settings = replace(settings, steps=len(result.steps), stop_curvature=None, stop_rate=None)
    return settings, prepared.own_scale


def run_frames(tasks: Sequence[FairingTask], *, one_strength: bool) -> Iterator[FairingTask]:
    """Fair frames with the same triangles; yield the task at hand after every step.

    Touches no Blender data. Of a finished task only the last step is kept.

    Parameters
    ----------
    tasks
        The frames, with one settings for all.
    one_strength
        Whether to smooth all of them as the first, see `same_strength`.
    """
    first = tasks[0]
    data, settings, scale = MeshData(first.vertices, first.triangles), first.settings, None
    try:
        if one_strength:
            settings, scale = same_strength(data, settings)
        prepared = PreparedMesh(data.vertices, data.triangles, settings, scale=scale)
    except FairingError as error:
        first.error = str(error)
        return
    for task in tasks:
        task.settings = settings
        yield from run_tasks([task], prepared)
        task.steps = task.steps[-1:]
