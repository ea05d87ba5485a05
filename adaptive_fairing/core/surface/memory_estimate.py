"""Memory that a refinement needs, estimated before it starts."""

from __future__ import annotations

from ..fem.memory_estimate import MemoryNeededError
from ..runtime.system_memory import available_bytes

# Bytes, bounds of what was measured on meshes of 1,600,000 refined triangles: 200 to 370 for
# connectivity, points and normals; 10 to 55 for each key, attribute and vertex group.
FIXED_BYTES = 50_000_000
BYTES_PER_TRIANGLE = 400
BYTES_PER_VALUE = 60


def require_memory(n_triangles: int, levels: int, n_arrays: int) -> None:
    """Refuse a refinement that does not fit into memory.

    Parameters
    ----------
    n_triangles : int
        Of the control mesh.
    levels : int
    n_arrays : int
        Shape keys, attributes and vertex groups that are refined with it.

    Raises
    ------
    MemoryNeededError
        The message has the numbers.  Nothing is raised if the system does not report its memory.
    """
    available = available_bytes()
    n_refined = n_triangles * 4**levels
    needed = FIXED_BYTES + (BYTES_PER_TRIANGLE + BYTES_PER_VALUE * n_arrays) * n_refined
    if available is not None and needed > available:
        raise MemoryNeededError(
            f"{n_refined} refined triangles need about {needed / 1e9:.1f} GB of memory, "
            f"{available / 1e9:.1f} GB are available: choose fewer levels",
            needed,
            available,
        )
