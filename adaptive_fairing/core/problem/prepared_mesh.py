"""Prepared mesh: everything that depends on the triangles alone, kept for other positions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..mesh.solver_mesh import Frame, SolverFrame, solvable_surface
from ..runtime.arrays import BoolArray, FloatArray, IntArray
from .caller_mesh import CallerMesh
from .prepared_surface import PreparedSurface
from .region import Region, part_around

DEFAULT_TOLERANCE = 1e-3


class PreparedMesh(PreparedSurface):
    """Cuts, numbering, patches, tables and sparsity pattern of a mesh, for any run.

    All of it depends on the triangles alone, but for the order of the solver's vertices, which also
    depends on the positions that the mesh was prepared with and changes the last bits of a result.
    So frames of a moving surface are all solved with the preparation of the first frame: their
    results then do not depend on which frames one process solves.

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
        Factor from object units into the solver's frame, such as `own_scale` of another
        preparation; by default it follows from the size of each mesh.  With one factor for several
        meshes one τ means the same time for all of them.

    Attributes
    ----------
    triangles : (m, 3) int
    surface : SolverSurface
        The manifold that is solved on.
    own_scale : float
        Factor from the units of `vertices` into the solver's frame.
    whole_run : object
        What `denoise` keeps of a run on the whole mesh, for runs on parts of it.

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
        super().__init__(solvable_surface(mesh.points, mesh.triangles), tolerance)
        self.triangles = mesh.triangles
        self.own_scale = SolverFrame.of(mesh.points, self.surface, normalize).scale
        self._scale = scale
        self.whole_run: object = None
        self._region_key: tuple[bytes, int, int] | None = None
        self._region: Region | None = None

    def region(
        self, points: FloatArray, moves: BoolArray, n_rings: int, least: int = 0
    ) -> Region | None:
        """Part of the surface around the vertices that may move, see `part_around`.

        The part of the last call is kept: a second run on the same vertices prepares nothing.
        """
        key = np.packbits(moves).tobytes(), n_rings, least
        if key != self._region_key:
            self._region_key, self._region = key, part_around(points, self, moves, n_rings, least)
        return self._region

    def serves(self, triangles: IntArray, n_vertices: int) -> bool:
        """Whether a mesh has the triangles that were prepared."""
        is_same_size = n_vertices == self.surface.vertex_of.max() + 1
        return is_same_size and np.array_equal(triangles, self.triangles)

    def require(self, triangles: IntArray, n_vertices: int, tolerance: float | None = None) -> None:
        """Check that this preparation is for a mesh, and for a tolerance if one is given.

        Raises
        ------
        InputError
            The preparation is for other triangles or another quadrature tolerance.
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
