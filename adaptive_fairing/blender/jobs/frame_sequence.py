"""Frames of one surface: shared analysis of the topology, shared strength."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from ...core import (
    DenoiseProgress,
    DenoiseSettings,
    FairingError,
    FairingSettings,
    denoise,
    fair,
)
from ...core.diffusion.smoothing_radius import radius_scale, suggest_tau
from ..data.mesh_arrays import MeshData, read_mesh
from ..files.mesh_files import import_mesh
from .file_job import Preparation, prepared_alone, solved_surface
from .frames import object_at_frame
from .solve import RunCancelledError, Settings, Solve, run_solves

Place = tuple[Path, int | None]
"""A file, and a frame in it; None for the mesh as it is stored."""


class Preparations:
    """Preparations of surfaces; that of a sequence's first frame is kept.

    A frame with other triangles than the first gets a preparation of its own. So the result of a
    frame does not depend on the frames that the same process has smoothed before.
    """

    def __init__(self) -> None:
        self._place: Place | None = None
        self._kept: Preparation | None = None

    def turn_to(
        self,
        reference: Place | None,
        object_name: str | None,
        settings: Settings,
        *,
        scale: float | None,
        keep_axes: bool,
    ) -> None:
        """Keep the preparation of the frame at a place, or none if the place is None.

        All other parameters must equal those of the last call with the same place.

        Raises
        ------
        FairingError, OSError
            The place cannot be read, or has no mesh to smooth.
        """
        if reference == self._place:
            return
        self._place, self._kept = reference, None
        if reference is not None:
            data = read_place(reference, object_name, keep_axes=keep_axes)
            is_one_strength = scale is not None
            self._kept = prepared_first(data, settings, scale, is_one_strength=is_one_strength)

    def of(self, data: MeshData, settings: Settings, scale: float | None) -> Preparation:
        """Return the kept preparation if it fits this surface, otherwise a new one."""
        kept = self._kept
        if kept is not None and kept.mesh.serves(data.triangles, len(data.vertices)):
            return kept
        return prepared_alone(data, settings, scale)


def prepared_first(
    data: MeshData,
    settings: Settings,
    scale: float | None,
    *,
    is_one_strength: bool,
    progress: Callable[[DenoiseProgress], None] | None = None,
) -> Preparation:
    """Prepare the first frame of a sequence; denoise it too, if all frames are to use its plan.

    `progress` is as for `denoise`.
    """
    preparation = prepared_alone(data, settings, scale)
    if not (is_one_strength and isinstance(settings, DenoiseSettings)):
        return preparation
    result = denoise(
        data.vertices, data.triangles, settings, prepared=preparation.mesh, progress=progress
    )
    return replace(preparation, plan=result.plan)


def read_place(place: Place, object_name: str | None, *, keep_axes: bool = False) -> MeshData:
    """Read the surface of a frame as a job would solve on it; replaces everything in Blender."""
    path, frame = place
    obj = import_mesh(path, object_name, keep_axes=keep_axes)
    if frame is not None:
        obj = object_at_frame(obj, frame)
    surface, _ = solved_surface(read_mesh(obj.data), path)
    return surface


def same_strength(data: MeshData, settings: Settings) -> tuple[Settings, float]:
    """Find settings and scale that smooth every frame as strongly as the first.

    Parameters
    ----------
    data
        Surface of the first frame.
    settings
        Settings of the run. A stopping rule would end frames after different numbers of steps, so
        its outcome on the first frame holds for all.

    Returns
    -------
    DenoiseSettings or FairingSettings
        Settings in which nothing, not even τ, is left for each frame to choose.
    float
        Scale into the solver's frame, see `PreparedMesh`.
    """
    prepared = prepared_alone(data, settings).mesh
    if isinstance(settings, FairingSettings):
        if settings.tau is None:
            scale = radius_scale(data.vertices, data.triangles, settings)
            settings = replace(settings, tau=suggest_tau(scale, settings.radius, settings.steps))
        if settings.stop_curvature or settings.stop_rate:
            steps = len(fair(data.vertices, data.triangles, settings, prepared=prepared).steps)
            settings = replace(settings, steps=steps, stop_curvature=None, stop_rate=None)
    return settings, prepared.own_scale


def run_frames(solves: Sequence[Solve], *, one_strength: bool) -> Iterator[Solve]:
    """Run frames with the same triangles; yield the current solve after every step.

    Does not touch Blender's data. Of a finished frame only the result is kept.

    Parameters
    ----------
    solves
        The frames, all with the same settings.
    one_strength
        Whether to smooth all of them like the first, see `same_strength`.
    """
    first = solves[0]
    data, settings, scale = MeshData(first.vertices, first.triangles), first.settings, None
    try:
        if one_strength:
            settings, scale = same_strength(data, settings)
        preparation = prepared_first(
            data,
            settings,
            scale,
            is_one_strength=one_strength,
            progress=first.note_progress,
        )
    except RunCancelledError:
        return
    except (FairingError, MemoryError) as error:
        first.failure = error
        return
    for solve in solves:
        if solve.is_cancelled:
            return
        solve.settings, solve.prepared, solve.plan = settings, preparation.mesh, preparation.plan
        yield from run_solves([solve])
        solve.keep_result_only()
        if solve.is_cancelled:
            return
