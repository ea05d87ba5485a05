"""Read and write binary PLY triangle meshes (float32 positions, int32 indices)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .triangles import Faces, FloatArray

FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def write_ply(path: Path, vertices: FloatArray, triangles: Faces, comment: str) -> None:
    """Write a mesh; positions are rounded to float32."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"comment {comment}\n"
        f"element vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), dtype=FACE)
    faces["count"], faces["corners"] = 3, triangles
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + faces.tobytes())


def read_ply(path: Path) -> tuple[FloatArray, Faces]:
    """Read a mesh written by `write_ply`."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    counts = [
        int(line.split()[-1]) for line in header.decode().splitlines() if line.startswith("element")
    ]
    n_vertices, n_triangles = counts
    vertices = np.frombuffer(body, "<f4", 3 * n_vertices).reshape(-1, 3)
    faces = np.frombuffer(body, FACE, n_triangles, offset=vertices.nbytes)
    return vertices.astype(float), faces["corners"].astype(np.int32)
