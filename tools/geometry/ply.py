"""Read and write binary PLY triangle meshes: float32 or float64 positions, int32 indices."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .triangles import Faces, FloatArray

FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
TYPES = {"float": "<f4", "double": "<f8"}


def write_ply(
    path: Path, vertices: FloatArray, triangles: Faces, comment: str = "", kind: str = "float"
) -> None:
    """Write a mesh; positions are rounded to float32 unless the kind is "double"."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        + (f"comment {comment}\n" if comment else "")
        + f"element vertex {len(vertices)}\n"
        + "".join(f"property {kind} {axis}\n" for axis in "xyz")
        + f"element face {len(triangles)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), dtype=FACE)
    faces["count"], faces["corners"] = 3, triangles
    path.write_bytes(header.encode() + vertices.astype(TYPES[kind]).tobytes() + faces.tobytes())


def read_ply(path: Path) -> tuple[FloatArray, Faces]:
    """Read a mesh written by `write_ply`."""
    header, body = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in header.decode().splitlines()]
    n_vertices, n_triangles = (int(words[-1]) for words in lines if words[0] == "element")
    (kind,) = {words[1] for words in lines if words[0] == "property" and words[-1] in "xyz"}
    vertices = np.frombuffer(body, TYPES[kind], 3 * n_vertices).reshape(-1, 3)
    faces = np.frombuffer(body, FACE, n_triangles, offset=vertices.nbytes)
    return vertices.astype(float), faces["corners"].astype(np.int32)
