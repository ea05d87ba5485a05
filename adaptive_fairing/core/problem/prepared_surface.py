"""Prepared surface: the manifold that is solved on, with its finite elements."""

from __future__ import annotations

import numpy as np

from ..errors import InputError, listed
from ..fem.loop_space import LoopSpace
from ..fem.memory_estimate import Algorithm, estimated_bytes, require_memory
from ..loop.patches import PatchSet
from ..mesh.solver_mesh import SolverSurface
from ..mesh.topology import TriangleTopology

# All neighbours of a vertex are coupled in each triangle around it: the local matrices there have
# half the cube of its valence entries. With so many a step takes about ten seconds; twice the
# valence is eight times that.
# `denoise` measures the surface, but has no such matrices: eight times as many take as long.
MOST_POLE_ENTRIES = {"fair": 3e8, "denoise": 2.4e9}
NOTABLE_VALENCE = 100


class PreparedSurface:
    """A surface with everything that a solve needs and that depends on the triangles alone.

    Parameters
    ----------
    surface : SolverSurface
    quadrature_tolerance : float
        As in `FairingSettings`.
    part_of : TriangleTopology, optional
        Larger surface that this one is a part of, see `PatchSet`.
    """

    def __init__(
        self,
        surface: SolverSurface,
        quadrature_tolerance: float,
        part_of: TriangleTopology | None = None,
    ) -> None:
        self.surface = surface
        self.quadrature_tolerance = quadrature_tolerance
        self._part_of = part_of
        self._patches: PatchSet | None = None
        self._space: LoopSpace | None = None
        self._admitted: set[Algorithm] = set()

    def space_for(self, algorithm: Algorithm) -> LoopSpace:
        """Finite element space of the surface for an algorithm, made once.

        Raises
        ------
        MemoryNeededError
            The solve does not fit into memory.
        InputError
            Vertices with so many neighbours that assembling the matrices would take minutes.
        """
        self.admit(algorithm)
        if self._space is None:
            tolerance = self.quadrature_tolerance
            self._space = LoopSpace(self.surface.topology, tolerance, self._known_patches())
        self._patches = None  # the space has what it needs of them
        return self._space

    def admit(self, algorithm: Algorithm) -> None:
        """Check once that an algorithm can run on the surface; raises as `space_for`."""
        if algorithm not in self._admitted:
            _require_moderate_poles(self.surface, MOST_POLE_ENTRIES[algorithm])
            require_memory(self._known_patches(), self.quadrature_tolerance, algorithm)
            self._admitted.add(algorithm)

    def free_space(self) -> None:
        """Free the finite element space, which holds most of the memory; a solve makes it anew."""
        self._space = None
        self._admitted.clear()

    def needed_bytes(self, algorithm: Algorithm) -> int:
        """Upper bound of the memory that a solve takes, in bytes, this preparation included."""
        return estimated_bytes(self._known_patches(), self.quadrature_tolerance, algorithm)

    def _known_patches(self) -> PatchSet:
        """Patches of the surface, kept until there is a space."""
        if self._patches is None:
            self._patches = PatchSet(self.surface.topology, self._part_of)
        return self._patches


def _require_moderate_poles(surface: SolverSurface, most_entries: float) -> None:
    """Refuse a mesh with so many neighbours at a vertex that a run would take minutes or hours."""
    valence = surface.topology.ring_size
    poles = np.flatnonzero(valence > NOTABLE_VALENCE)
    if np.sum(valence[poles].astype(np.float64) ** 3) / 2 > most_entries:
        raise InputError(
            f"{len(poles)} vertices have more than {NOTABLE_VALENCE} neighbours, up to "
            f"{valence.max()}: vertices {listed(surface.vertex_of[poles])}; a run would take "
            "minutes, remesh there"
        )
