"""The committed sample meshes: what they promise, and that the tool makes them again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

ASSETS = Path(__file__).resolve().parents[2] / "assets"
NAMES = ("head", "foot", "crocodile")
FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def read(name):
    """Return float32 positions and triangles: a reader of its own, independent of the tool's."""
    header, body = (ASSETS / f"{name}.ply").read_bytes().split(b"end_header\n", 1)
    words = header.decode().split()
    n_vertices = int(words[words.index("vertex") + 1])
    n_triangles = int(words[words.index("face") + 1])
    assert len(body) == 12 * n_vertices + FACE.itemsize * n_triangles
    vertices = np.frombuffer(body, "<f4", 3 * n_vertices).reshape(-1, 3)
    faces = np.frombuffer(body, FACE, n_triangles, offset=12 * n_vertices)
    assert np.all(faces["count"] == 3)
    return vertices, faces["corners"].astype(np.int64)


def half_edges(triangles):
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def local_edges(vertices, triangles):
    """Return the mean length of the edges at every vertex (each edge is two half-edges)."""
    half = half_edges(triangles)
    length = np.linalg.norm(np.diff(vertices[half].astype(float), axis=1)[:, 0], axis=1)
    return np.bincount(half[:, 0], length) / np.bincount(half[:, 0])


def normals(vertices, triangles):
    """Return area-weighted normals (m, 3), not normalised."""
    corners = vertices[triangles].astype(float)
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def angles(vertices, triangles):
    corners = vertices[triangles].astype(float)
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(corners, 1, axis=1) - corners
    sine = np.linalg.norm(np.cross(after, before), axis=2)
    return np.degrees(np.arctan2(sine, np.sum(after * before, axis=2)))


def umbrellas(triangles, n_vertices):
    """Count the closed fans of triangles over all vertices."""
    # Around a vertex the triangles (v, a, b) step from a to b: a permutation of (v, a) pairs,
    # whose cycles are the fans.
    rotated = np.concatenate([triangles, triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]])
    start = rotated[:, 0] * n_vertices + rotated[:, 1]
    order = np.argsort(start)
    step = order[np.searchsorted(start[order], rotated[:, 0] * n_vertices + rotated[:, 2])]
    seen = np.zeros(len(step), dtype=bool)
    count = 0
    for first in range(len(step)):
        if seen[first]:
            continue
        count += 1
        here = first
        while not seen[here]:
            seen[here] = True
            here = step[here]
    return count


@pytest.mark.parametrize("name", NAMES)
def test_closed_oriented_manifold(name):
    vertices, triangles = read(name)
    half = half_edges(triangles)
    key = half[:, 0] * len(vertices) + half[:, 1]
    assert len(np.unique(key)) == len(key)  # every directed edge once ...
    assert np.array_equal(np.sort(key), np.sort(half[:, 1] * len(vertices) + half[:, 0]))
    assert np.array_equal(np.unique(triangles), np.arange(len(vertices)))
    assert umbrellas(triangles, len(vertices)) == len(vertices)
    corners = vertices[triangles].astype(float)
    assert np.linalg.det(corners).sum() > 0  # six times the volume: normals point outwards


@pytest.mark.parametrize("name", NAMES)
def test_no_handles(name):
    vertices, triangles = read(name)
    assert len(vertices) - len(triangles) // 2 == 2  # Euler characteristic of a sphere


@pytest.mark.parametrize("name", NAMES)
def test_feature_adaptive_with_good_triangles(name):
    vertices, triangles = read(name)
    low, high = np.percentile(local_edges(vertices, triangles), [1, 99])
    assert high / low > 10
    assert 10_000 <= len(triangles) <= 60_000
    assert angles(vertices, triangles).min() > 5
    assert np.bincount(triangles.ravel()).min() >= 3


@pytest.mark.parametrize("name", NAMES)
def test_noise_lies_along_normals_and_follows_local_edges(name):
    clean, triangles = read(name)
    noisy, noisy_triangles = read(f"{name}_noisy")
    assert np.array_equal(triangles, noisy_triangles)
    direction = np.zeros((len(clean), 3))
    face_normals = normals(clean, triangles)
    for corner in range(3):
        np.add.at(direction, triangles[:, corner], face_normals)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    move = (noisy.astype(float) - clean) / local_edges(clean, triangles)[:, None]
    height = np.sum(move * direction, axis=1)
    assert np.abs(move - height[:, None] * direction).max() < 1e-3  # float32 of the files
    assert 0.13 < height.std() < 0.25
    assert abs(height.mean()) < 0.01
    dense = local_edges(clean, triangles) < np.median(local_edges(clean, triangles))
    assert height[dense].std() == pytest.approx(height[~dense].std(), rel=0.05)


def test_assets_are_small():
    sizes = {path.name: path.stat().st_size for path in ASSETS.glob("*.ply")}
    assert set(sizes) == {f"{name}{end}.ply" for name in NAMES for end in ("", "_noisy")}
    assert sizes["head_noisy.ply"] < 600_000
    assert sum(sizes.values()) < 6_000_000


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
def test_the_tool_makes_them_again(name):
    pytest.importorskip("bpy")
    from research.samples import __main__ as samples

    clean, noisy, triangles = samples.make(samples.SAMPLES[name])
    for made, suffix in ((clean, ""), (noisy, "_noisy")):
        stored, stored_triangles = read(name + suffix)
        assert np.array_equal(triangles, stored_triangles)
        np.testing.assert_allclose(made, stored, atol=1e-4)
