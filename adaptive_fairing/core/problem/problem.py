"""Solver's problem, posed from the caller's mesh."""

from __future__ import annotations

from typing import NamedTuple

from ..fem.loop_space import LoopSpace
from ..fem.memory_estimate import Algorithm
from ..mesh.solver_mesh import Frame, SolverFrame
from ..runtime.arrays import BoolArray, FloatArray
from .caller_mesh import CallerMesh
from .diagnosis import surface_notes
from .prepared_mesh import PreparedMesh


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
        What is wrong with the mesh and how it was made solvable, one line each.
    """

    space: LoopSpace
    frame: SolverFrame
    start: FloatArray
    weights: FloatArray
    is_held: BoolArray
    notes: tuple[str, ...]

    @classmethod
    def posed(
        cls,
        mesh: CallerMesh,
        prepared: PreparedMesh,
        algorithm: Algorithm,
        *,
        boundary: str,
        normalize: Frame = "box",
    ) -> SolverProblem:
        """Go over to the solver's mesh.

        Raises
        ------
        MemoryNeededError
            The solve cannot fit into memory.
        """
        surface, topology = prepared.surface, prepared.surface.topology
        frame = prepared.frame(mesh.points, normalize)
        weights = mesh.weights[surface.vertex_of]
        is_held = (weights == 0) | topology.is_loose | surface.is_cut
        if boundary == "fixed":
            is_held |= topology.on_boundary
        start = frame.inward(mesh.points)
        space = prepared.space_for(algorithm)
        return cls(space, frame, start, weights, is_held, surface_notes(start, surface))
