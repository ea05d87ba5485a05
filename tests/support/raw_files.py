"""Mesh files written byte by byte, without Blender: also those that Blender would not write."""

from __future__ import annotations

import json
import struct

import numpy as np


def obj_bytes(vertices, faces, *, digits=9, between=""):
    """Write a .obj file; `between` is text between the vertices and the faces."""
    lines = ["v " + " ".join(f"{x:.{digits}g}" for x in point) + "\n" for point in vertices]
    lines += [between, *("f " + " ".join(str(i + 1) for i in face) + "\n" for face in faces)]
    return "".join(lines).encode()


def ply_bytes(
    vertices, faces, *, form="binary_little_endian", number="float", n_vertices=None, n_faces=None
):
    """Write a .ply file; the header may promise other numbers than there are."""
    header = (
        f"ply\nformat {form} 1.0\ncomment made by a test\n"
        f"element vertex {len(vertices) if n_vertices is None else n_vertices}\n"
        f"property {number} x\nproperty {number} y\nproperty {number} z\n"
        f"element face {len(faces) if n_faces is None else n_faces}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()
    if form == "ascii":
        rows = ["{:.9g} {:.9g} {:.9g}\n".format(*point) for point in vertices]
        rows += [" ".join(map(str, [len(face), *face])) + "\n" for face in faces]
        return header + "".join(rows).encode()
    order = ">" if "big" in form else "<"
    points = np.asarray(vertices, dtype=order + {"float": "f4", "double": "f8"}[number]).tobytes()
    return (
        header
        + points
        + b"".join(struct.pack(f"{order}B{len(face)}i", len(face), *face) for face in faces)
    )


def stl_bytes(vertices, faces, *, form="binary", n_faces=None):
    """Write a .stl file of triangles."""
    corners = np.asarray(vertices, dtype="<f4")[np.asarray(faces)]
    if form == "ascii":
        facets = [
            "facet normal 0 0 1\nouter loop\n"
            + "".join("vertex {:.9g} {:.9g} {:.9g}\n".format(*point) for point in triangle)
            + "endloop\nendfacet\n"
            for triangle in corners
        ]
        return ("solid s\n" + "".join(facets) + "endsolid s\n").encode()
    rows = b"".join(bytes(12) + triangle.tobytes() + bytes(2) for triangle in corners)
    return bytes(80) + struct.pack("<I", len(faces) if n_faces is None else n_faces) + rows


def glb_bytes(vertices, faces, *, n_vertices=None, change=None, more=b""):
    """Write a .glb file of triangles; its accessor may promise another number of vertices.

    `change` alters its description; `more` are bytes behind those of the mesh.
    """
    points = np.asarray(vertices, dtype="<f4")
    indices = np.asarray(faces, dtype="<u4").tobytes()
    binary = points.tobytes() + indices
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": len(indices)},
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "type": "VEC3",
                "count": len(points) if n_vertices is None else n_vertices,
                "min": [-9, -9, -9], "max": [9, 9, 9],
            },
            {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3 * len(faces)},
        ],
    }  # fmt: skip
    if change is not None:
        change(scene)
    binary += more
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


WRITERS = {
    "obj": (".obj", obj_bytes, {}),
    "ply": (".ply", ply_bytes, {}),
    "big-endian ply": (".ply", ply_bytes, {"form": "binary_big_endian"}),
    "ply as text": (".ply", ply_bytes, {"form": "ascii"}),
    "stl": (".stl", stl_bytes, {}),
    "stl as text": (".stl", stl_bytes, {"form": "ascii"}),
    "glb": (".glb", glb_bytes, {}),
}
"""Kinds of files: suffix, function that writes one, its options."""


def write_raw(folder, kind, vertices, faces, **options):
    """Write a file of a kind; give its path."""
    suffix, function, given = WRITERS[kind]
    path = folder / f"given{suffix}"
    path.write_bytes(function(vertices, faces, **given, **options))
    return path
