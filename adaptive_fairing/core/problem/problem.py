"""Solver's problem, posed from the caller's mesh."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..fem.loop_space import LoopSpace
from ..fem.memory_estimate import Algorithm
from ..mesh.solver_mesh import Frame, SolverFrame
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray, IndexArray
from .caller_mesh import CallerMesh
from .diagnosis import surface_notes
from .prepared_mesh import PreparedMesh


class Margin(NamedTuple):
    """Size of the part around the moving vertices that is solved on.

    Attributes
    ----------
    n_rings, least : int
        See `rings_around`.
    """

    n_rings: int
    least: int = 0


class WholeSurface(NamedTuple):
    """The whole surface, of which the solve may cover a part.

    Attributes
    ----------
    frame : SolverFrame
    start : (n, 3)
        Positions in the solver's frame.
    part : (k,) int
        The vertices that are solved on, in the order of the problem.
    """

    frame: SolverFrame
    start: FloatArray
    part: IndexArray

    @property
    def topology(self) -> TriangleTopology:
        """Connectivity of the whole surface."""
        return self.frame.surface.topology

    def to_caller(self, values: FloatArray, elsewhere: FloatArray) -> FloatArray:
        """Values (k,) at the vertices that are solved on, as values at the caller's vertices.

        `elsewhere` (n,) are the values at the other vertices of the whole surface.
        """
        of_all = elsewhere.copy()
        of_all[self.part] = values
        return self.frame.to_caller(of_all)


class SolverProblem(NamedTuple):
    """A caller's mesh on the solver's mesh; arrays (n, ...) in the order of its vertices.

    Attributes
    ----------
    space : LoopSpace
    frame : SolverFrame
        The way back to the caller's mesh.
    start : (n, 3)
        Positions in the solver's frame.
    weights : (n,)
    is_held : (n,) bool
        Vertices that must stay: of weight 0, loose, on cuts, and on a fixed boundary.
    notes : tuple of str
        Defects of the mesh and how it was made solvable, one line each.
    whole : WholeSurface
        Surface that the vertices are a part of, in the same frame.
    is_part : bool
        Whether they are fewer than those of the whole surface.
    """

    space: LoopSpace
    frame: SolverFrame
    start: FloatArray
    weights: FloatArray
    is_held: BoolArray
    notes: tuple[str, ...]
    whole: WholeSurface
    is_part: bool

    @classmethod
    def posed(
        cls,
        mesh: CallerMesh,
        prepared: PreparedMesh,
        algorithm: Algorithm,
        *,
        boundary: str,
        normalize: Frame = "box",
        margin: Margin | None = None,
    ) -> SolverProblem:
        """Pose the problem on the solver's mesh; with a margin, on the part of it that may move.

        Raises
        ------
        MemoryNeededError
            The solve does not fit into memory.
        """
        frame = prepared.frame(mesh.points, normalize)
        start = frame.inward(mesh.points)
        weights = mesh.weights[prepared.surface.vertex_of]
        region = None
        if margin is not None and not weights.all():
            region = prepared.region(start, weights > 0, *margin)
        part = np.arange(len(start)) if region is None else region.inner_of
        solved = region or prepared
        surface, topology = solved.surface, solved.surface.topology
        weights = weights[part]
        is_held = (weights == 0) | topology.is_loose | surface.is_cut
        if boundary == "fixed":
            is_held |= topology.on_boundary
        return cls(
            solved.space_for(algorithm),
            replace(frame, surface=surface),
            start[part],
            weights,
            is_held,
            surface_notes(start, prepared.surface),
            WholeSurface(frame, start, part),
            region is not None,
        )
