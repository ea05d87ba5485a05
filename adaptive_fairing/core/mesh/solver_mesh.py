"""Solver's mesh made from the caller's: numbering, cuts, units.

The solver numbers the vertices so that neighbours are close in memory, cuts the mesh apart where it
is not an oriented manifold, and works in a frame of its own, by default the paper's box [-3, 3]³.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from ..errors import TopologyError
from ..runtime.arrays import BoolArray, FloatArray, IndexArray, IntArray, LongArray
from .enclosing_sphere import smallest_enclosing_sphere
from .input_checks import bounding_box
from .manifold import cut_to_manifold
from .renumbering import sweep_order
from .topology import TriangleTopology

FRAME_SIZE = 6.0  # the paper resizes the mesh into the box [-3, 3]³

Frame: TypeAlias = Literal["box", "sphere", False]
"""Length that is scaled to `FRAME_SIZE`: the longest side of the box around the mesh, or the
diameter of the smallest sphere around it, which is the same for a turned mesh; or none."""

FRAMES = ("box", "sphere")


@dataclass(frozen=True)
class SolverSurface:
    """The manifold that is solved on: renumbered, and cut where the caller's mesh is not manifold.

    Attributes
    ----------
    topology : TriangleTopology
    vertex_of : (n,) int
        The caller's vertex behind each of the solver's.
    is_cut : (n,) bool
        Vertices at a cut.
    notes : tuple of str
        What was cut or turned, with counts.
    left_out : (k,) int
        The caller's triangles that are not solved on.
    """

    topology: TriangleTopology
    vertex_of: IndexArray
    is_cut: BoolArray
    notes: tuple[str, ...] = ()
    left_out: LongArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))


def solvable_surface(points: FloatArray, triangles: IntArray) -> SolverSurface:
    """Renumber the caller's triangles; cut them only if they are not an oriented manifold."""
    try:
        order = sweep_order(points, triangles)
        topology = TriangleTopology(order.triangles, len(points))
        return SolverSurface(topology, order.vertices, np.zeros(len(points), dtype=bool))
    except TopologyError:
        mesh = cut_to_manifold(triangles, len(points))
    order = sweep_order(points[mesh.vertex_of], mesh.triangles)
    topology = TriangleTopology(order.triangles, len(mesh.vertex_of))
    return SolverSurface(
        topology,
        mesh.vertex_of[order.vertices],
        mesh.is_held[order.vertices],
        mesh.notes,
        mesh.left_out,
    )


@dataclass(frozen=True)
class SolverFrame:
    """The solver's coordinates, and the way back to the caller's."""

    centre: FloatArray
    scale: float
    surface: SolverSurface

    @classmethod
    def of(cls, points: FloatArray, surface: SolverSurface, normalize: Frame) -> SolverFrame:
        """Fit the frame to all vertices that have a triangle."""
        used = surface.vertex_of[~surface.topology.is_loose]
        low, high = bounding_box(points, used)
        size = float((high - low).max())
        if normalize == "sphere":
            size = 2 * smallest_enclosing_sphere(points[used])[1]
        scale = FRAME_SIZE / size if normalize and size > 0 else 1.0
        # Always centred: far from the origin coordinates have fewer digits for the shape.
        return cls(low + (high - low) / 2, scale, surface)

    def inward(self, points: FloatArray) -> FloatArray:
        """Positions of the solver's vertices, (n, 3), in the solver's frame."""
        inner = np.take(points, self.surface.vertex_of, axis=0)
        inner -= self.centre
        inner *= self.scale
        return inner

    def outward(self, current: FloatArray, points: FloatArray, is_held: BoolArray) -> FloatArray:
        """Positions of the caller's vertices; held ones have those of `points`, bit by bit."""
        positions = points.copy()
        outer = current / self.scale
        outer += self.centre
        positions[self.surface.vertex_of] = outer
        # All copies of a vertex that was cut apart are held.
        held = self.surface.vertex_of[is_held]
        positions[held] = points[held]
        return positions

    def displaced(self, points: FloatArray, displacement: FloatArray) -> FloatArray:
        """Positions of the caller's vertices after the solver's displacements (n, 3).

        Where the displacement is 0, they equal `points` bit by bit.
        """
        positions = points.copy()
        moves = displacement.any(axis=1)
        positions[self.surface.vertex_of[moves]] += displacement[moves] / self.scale
        return positions

    def to_caller(self, values: FloatArray) -> FloatArray:
        """Values (n,) of the solver's vertices as values of the caller's vertices."""
        result = np.zeros(self.surface.vertex_of.max() + 1)
        result[self.surface.vertex_of] = values
        return result
