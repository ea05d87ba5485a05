"""Cache of the last refinement, which the redo panel repeats again and again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.runtime.arrays import FloatArray, SingleArray
from ...core.surface.cut_surface import CutSurface, cut_surface
from ...core.surface.refined_net import RefinedNet

LARGEST_KEPT = 2_000_000
"""Number of triangles from which on a refined mesh is not cached: it takes too much memory."""


class RefinedShape(NamedTuple):
    """Positions (n, 3) on a net, and normals, see `Refinement.shape`."""

    positions: SingleArray
    normals: FloatArray | None


@dataclass
class Refinement:
    """Surface of a control mesh, and the results computed on it so far.

    Attributes
    ----------
    cut : CutSurface
    """

    cut: CutSurface
    _input: tuple[NDArray, ...]
    _nets: dict[int, RefinedNet] = field(default_factory=dict)
    _shapes: dict[tuple[int, bool, bool], tuple[NDArray, RefinedShape]] = field(
        default_factory=dict
    )

    def net(self, levels: int) -> RefinedNet:
        """Make the connectivity after some steps, once."""
        if levels not in self._nets:
            self._nets[levels] = RefinedNet(self.cut, levels)
        return self._nets[levels]

    def shape(
        self, positions: NDArray, levels: int, *, on_limit: bool, has_normals: bool = False
    ) -> RefinedShape:
        """Refine a shape.

        Parameters
        ----------
        positions : (n, 3)
            Of the control mesh.
        levels : int
        on_limit : bool
            Points of the limit surface, or control points of the finer mesh.
        has_normals : bool
            Whether to compute exact normals: of the vertices, (n, 3), or of the triangles'
            corners, (3 m, 3), where they differ at a vertex.
        """
        key = levels, on_limit, has_normals
        known = self._shapes.get(key)
        if known is not None and np.array_equal(known[0], positions):
            return known[1]
        net, surface = self.net(levels), self.cut.levels
        start = positions[self.cut.vertex_of].astype(np.float64, copy=False)
        control = surface.control_points(start, levels)
        normals = None
        if has_normals:
            points, normals, of_sectors = surface.points_and_normals(control)
            if self.cut.is_cut or surface.has_creases:
                of_corners = surface.corner_normals(normals, of_sectors, levels)
                normals = net.corner_normals(of_corners).reshape(-1, 3)
        elif on_limit:
            points = surface.limit_points(control)
        places = points if on_limit else control[-1]
        shape = RefinedShape(net.joined(places).astype(np.float32), normals)
        if has_normals:
            self._shapes[key] = positions.copy(), shape
        return shape


_last: list[Refinement] = []  # at most one


def refinement_of(
    triangles: NDArray[np.int32],
    n_vertices: int,
    creases: NDArray,
    held: NDArray,
    levels: int,
) -> Refinement:
    """Make a refinement, or return the last one if it is the same.

    Parameters as for `cut_surface`; `levels` is the number of steps that will be asked for.
    """
    given = triangles, np.array(n_vertices), creases, held
    if _last and all(map(np.array_equal, _last[0]._input, given)):
        return _last[0]
    forget()
    new = Refinement(cut_surface(triangles, n_vertices, creases, held), given)
    if len(triangles) * 4**levels <= LARGEST_KEPT:
        _last.append(new)
    return new


def forget() -> None:
    """Free the memory of the last refinement."""
    _last.clear()
