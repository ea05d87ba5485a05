"""Prepared mesh: everything that depends on the triangles alone, kept for other positions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError, listed
from ..fem.loop_space import LoopSpace
from ..fem.memory_estimate import Algorithm, estimated_bytes, require_memory
from ..loop.patches import PatchSet
from ..mesh.solver_mesh import Frame, SolverFrame, SolverSurface, solvable_surface
from ..runtime.arrays import FloatArray, IntArray
from .caller_mesh import CallerMesh

DEFAULT_TOLERANCE = 1e-3

# All neighbours of a vertex are coupled in each triangle around it: the local matrices there have
# half the cube of its valence entries. With so many a step takes about ten seconds; twice the
# valence is eight times that.
# `denoise` measures the surface, but has no such matrices: eight times as many take as long.
MOST_POLE_ENTRIES = {"fair": 3e8, "denoise": 2.4e9}
NOTABLE_VALENCE = 100


class PreparedMesh:
    """Cuts, numbering, patches, tables and sparsity pattern of a mesh, for any run.

    They depend on the triangles; the order of the solver's vertices, hence the last bits of the
    result, also on the positions that the mesh was prepared with.  Frames of a moving surface that
    are all solved with the preparation of the first have results that do not depend on which of
    them are solved where.

    Parameters
    ----------
    vertices : (n, 3) float
        Positions to prepare with.
    faces : (m, 3) int
        As for `fair_steps`.
    quadrature_tolerance : float
        As in `FairingSettings`.
    normalize : "box", "sphere" or False
        As in `FairingSettings`.
    scale : float, optional
        Factor from every mesh into the solver's frame, such as `own_scale` of another preparation,
        instead of one from each mesh's own size: one τ then means the same time, in the units of
        the meshes, for all of them.

    Attributes
    ----------
    triangles : (m, 3) int
    surface : SolverSurface
        The manifold that is solved on.
    own_scale : float
        Factor from the units of `vertices` into the solver's frame.

    Raises
    ------
    InputError
        As `fair_steps`.
    """

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        quadrature_tolerance: float = DEFAULT_TOLERANCE,
        normalize: Frame = "box",
        scale: float | None = None,
    ) -> None:
        mesh = CallerMesh.checked(vertices, faces)
        self._prepare(mesh, quadrature_tolerance, normalize, scale)

    @classmethod
    def of(
        cls,
        mesh: CallerMesh,
        *,
        quadrature_tolerance: float = DEFAULT_TOLERANCE,
        normalize: Frame = "box",
    ) -> PreparedMesh:
        """Prepare a mesh that has been checked."""
        prepared = cls.__new__(cls)
        prepared._prepare(mesh, quadrature_tolerance, normalize, None)
        return prepared

    def _prepare(
        self, mesh: CallerMesh, tolerance: float, normalize: Frame, scale: float | None
    ) -> None:
        self.triangles = mesh.triangles
        self.quadrature_tolerance = tolerance
        self.surface = solvable_surface(mesh.points, mesh.triangles)
        self.own_scale = SolverFrame.of(mesh.points, self.surface, normalize).scale
        self._scale = scale
        self._space: LoopSpace | None = None

    def space_for(self, algorithm: Algorithm) -> LoopSpace:
        """Finite element space of the surface, made at the first call.

        Raises
        ------
        MemoryNeededError
            The solve cannot fit into memory.
        InputError
            Vertices with so many neighbours that assembling the matrices would take minutes.
        """
        if self._space is None:
            _require_moderate_poles(self.surface, MOST_POLE_ENTRIES[algorithm])
            patches = PatchSet(self.surface.topology)
            require_memory(patches, self.quadrature_tolerance, algorithm)
            self._space = LoopSpace(self.surface.topology, self.quadrature_tolerance, patches)
        return self._space

    def needed_bytes(self, algorithm: Algorithm) -> int:
        """Upper bound of the memory that a solve takes, this preparation included."""
        patches = PatchSet(self.surface.topology)
        return estimated_bytes(patches, self.quadrature_tolerance, algorithm)

    def serves(self, triangles: IntArray, n_vertices: int) -> bool:
        """Whether a mesh has the triangles that were prepared."""
        is_same_size = n_vertices == self.surface.vertex_of.max() + 1
        return is_same_size and np.array_equal(triangles, self.triangles)

    def require(self, triangles: IntArray, n_vertices: int, tolerance: float | None = None) -> None:
        """Check that this is the preparation of a mesh, and for a tolerance if one is given.

        Raises
        ------
        InputError
            It was made for other triangles or another quadrature.
        """
        if not self.serves(triangles, n_vertices):
            raise InputError("the prepared mesh has other triangles than the one to fair")
        if tolerance is not None and tolerance != self.quadrature_tolerance:
            raise InputError(
                f"the mesh was prepared with quadrature_tolerance {self.quadrature_tolerance:g}, "
                f"the settings have {tolerance:g}"
            )

    def frame(self, points: FloatArray, normalize: Frame) -> SolverFrame:
        """Solver's frame for positions of this surface, with their own centre."""
        frame = SolverFrame.of(points, self.surface, normalize)
        return frame if self._scale is None else replace(frame, scale=self._scale)


def _require_moderate_poles(surface: SolverSurface, most_entries: float) -> None:
    """Refuse vertices with so many neighbours that a run would take minutes or hours."""
    valence = surface.topology.ring_size
    poles = np.flatnonzero(valence > NOTABLE_VALENCE)
    if np.sum(valence[poles].astype(np.float64) ** 3) / 2 > most_entries:
        raise InputError(
            f"{len(poles)} vertices have more than {NOTABLE_VALENCE} neighbours, up to "
            f"{valence.max()}: vertices {listed(surface.vertex_of[poles])}; a run would take "
            "minutes, remesh there"
        )
