"""What every solve starts with: the caller's arrays, checked, then posed on the solver's mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..fem.loop_space import LoopSpace
from ..fem.memory_estimate import Algorithm
from ..mesh.input_checks import checked_vertices, checked_weights, require_surface
from ..mesh.solver_mesh import Frame, SolverFrame
from ..mesh.topology import checked_triangles
from ..runtime.arrays import BoolArray, FloatArray, IntArray
from .diagnosis import surface_notes
from .prepared_mesh import PreparedMesh


class CallerMesh(NamedTuple):
    """A mesh as the caller sees it, checked.

    Attributes
    ----------
    points : (n, 3)
    triangles : (m, 3) int32
    weights : (n,)
        In [0, 1]; a vertex of weight 0 stays where it is.
    """

    points: FloatArray
    triangles: IntArray
    weights: FloatArray

    @classmethod
    def checked(
        cls, vertices: ArrayLike, faces: ArrayLike, weights: ArrayLike | None
    ) -> CallerMesh:
        """Check and copy the arrays: the caller may change them while a run goes on.

        Raises
        ------
        InputError
            Arrays of the wrong shape or type, coordinates that are not finite, indices or weights
            out of range, no triangle at all.
        """
        points = checked_vertices(vertices)
        triangles = checked_triangles(np.array(faces), len(points))
        require_surface(points, triangles)
        return cls(points, triangles, checked_weights(weights, len(points)))


class SolverProblem(NamedTuple):
    """The same on the solver's mesh; arrays (n, ...) in the order of its vertices.

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
