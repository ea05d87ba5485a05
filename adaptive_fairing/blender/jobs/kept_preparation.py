"""Set-up of the last mesh, kept from one press to the next as long as its triangles stay.

No bpy: a solve uses it in its thread.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...core import PreparedMesh

LARGEST_KEPT = 400_000
"""Number of triangles from which on only connectivity is kept: the rest takes 1 kB for each."""


class KeptPreparation:
    """The preparation of one mesh."""

    def __init__(self) -> None:
        self._kept: PreparedMesh | None = None

    def of(
        self, vertices: NDArray[np.float64], triangles: NDArray[np.int32], tolerance: float
    ) -> PreparedMesh:
        """Return the kept preparation if it fits these triangles, otherwise make and keep one.

        Raises
        ------
        FairingError
            As `PreparedMesh`.
        """
        from ...core import PreparedMesh

        kept = self.known(triangles, len(vertices))
        if kept is None or kept.quadrature_tolerance != tolerance:
            self._kept = None  # before the next one takes its memory
            kept = PreparedMesh(vertices, triangles, quadrature_tolerance=tolerance)
            self._kept = kept
        return kept

    def known(self, triangles: NDArray[np.int32], n_vertices: int) -> PreparedMesh | None:
        """Return the kept preparation if it is of these triangles."""
        kept = self._kept
        return kept if kept is not None and kept.serves(triangles, n_vertices) else None

    def release(self) -> None:
        """Free the parts that are too large to keep until the next press."""
        if self._kept is not None and len(self._kept.triangles) > LARGEST_KEPT:
            self._kept.free_space()

    def clear(self) -> None:
        """Keep nothing."""
        self._kept = None


preparations = KeptPreparation()
"""That of the last run from Blender's window."""
