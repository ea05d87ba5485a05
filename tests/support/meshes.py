"""Small meshes that the tests make themselves, each the same on every run.

Every generator returns ``(vertices, faces)``: float64 positions of shape ``(n_vertices, 3)`` and
int32 triangles of shape ``(n_triangles, 3)``, counter-clockwise seen from outside (from +z for the
flat ones).
"""

from bisect import insort

import numpy as np
from scipy.spatial import ConvexHull

from tools.geometry import triangles
from tools.geometry.triangles import edges_of, icosahedron, icosphere, split_1_to_4

__all__ = ["edges_of", "icosahedron", "icosphere", "split_1_to_4"]

Mesh = tuple[np.ndarray, np.ndarray]


# Closed meshes -----------------------------------------------------------------------------------


def tetrahedron() -> Mesh:
    """Return the regular tetrahedron in the unit sphere: 4 vertices of valence 3."""
    corners = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    return _on_sphere(corners), _faces([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)])


def octahedron() -> Mesh:
    """Return the regular octahedron in the unit sphere: 6 vertices of valence 4."""
    return bipyramid(4)


def bipyramid(n_segments: int) -> Mesh:
    """Return two poles of valence ``n_segments`` over one equator: the smallest such sphere."""
    return latlong_sphere(n_segments, 1)


def latlong_sphere(n_segments: int, n_rings: int) -> Mesh:
    """Return a unit sphere of ``n_rings`` circles of latitude and two poles.

    The poles are the last two vertices (north, south) and have valence ``n_segments``.
    """
    latitude = np.pi * (np.arange(1, n_rings + 1) / (n_rings + 1))[:, None]
    longitude = (2 * np.pi * np.arange(n_segments) / n_segments)[None, :]
    rings = np.stack(
        [
            np.sin(latitude) * np.cos(longitude),
            np.sin(latitude) * np.sin(longitude),
            np.cos(latitude) + 0 * longitude,
        ],
        axis=-1,
    ).reshape(-1, 3)
    north, south = len(rings), len(rings) + 1
    index = np.arange(len(rings)).reshape(n_rings, n_segments)
    after = np.roll(index, -1, axis=1)
    faces = np.concatenate(
        [
            _columns(np.full(n_segments, north), index[0], after[0]),
            _columns(index[:-1], index[1:], after[:-1]),
            _columns(index[1:], after[1:], after[:-1]),
            _columns(np.full(n_segments, south), after[-1], index[-1]),
        ]
    )
    return np.vstack([rings, [(0, 0, 1), (0, 0, -1)]]).astype(float), faces


def torus(n_major: int, n_minor: int, major: float = 2.0, minor: float = 1.0) -> Mesh:
    """Return a torus grid: ``n_major * n_minor`` vertices, all regular. 3 x 3 is allowed."""
    return triangles.torus(major, minor, (n_major, n_minor))


def seven_vertex_torus() -> Mesh:
    """Return the torus of 7 vertices and 14 triangles, in which every two vertices are adjacent.

    All vertices are regular, and every patch (12 control points) meets some vertices twice. The
    positions are without symmetry, so that no entry is right by luck.
    """
    i = np.arange(7)
    faces = np.concatenate(
        [_columns(i, (i + 1) % 7, (i + 3) % 7), _columns(i, (i + 3) % 7, (i + 2) % 7)]
    )
    return np.random.default_rng(7).normal(size=(7, 3)), faces


def random_closed(seed: int, coarse: Mesh | None = None, noise: float = 0.02) -> Mesh:
    """Return a bumpy sphere of random connectivity with valences 3 to 10 and 80 faces.

    An icosphere, or another mesh of the sphere, whose edges were flipped at random (simplicial
    throughout), relaxed on the sphere until hardly a triangle is folded over, then moved along
    random directions by ``noise`` times the radius.
    """
    generator = np.random.default_rng(seed)
    vertices, faces = coarse or icosphere(1)
    faces = _flip_random_edges(faces, len(vertices), 2 * len(faces), generator)
    start, end = edges_of(faces).T
    for _ in range(60):
        total = np.zeros_like(vertices)
        np.add.at(total, start, vertices[end])
        np.add.at(total, end, vertices[start])
        vertices = total / np.linalg.norm(total, axis=1, keepdims=True)
        vertices -= vertices.mean(axis=0)  # without it everything slides into one point
    return vertices + noise * generator.normal(size=vertices.shape), faces


def random_hull(seed: int, n_vertices: int) -> Mesh:
    """Return the convex hull of random points on the sphere: triangles of all shapes.

    Its vertices have 3 to 10 neighbours; seeds of hulls with other valences are passed over.
    """
    generator = np.random.default_rng((seed, n_vertices))
    while True:
        vertices = _on_sphere(generator.normal(size=(n_vertices, 3)))
        faces = ConvexHull(vertices).simplices
        a, b, c = vertices[faces].transpose(1, 0, 2)
        outward = np.einsum("fd,fd->f", np.cross(b - a, c - a), a - vertices.mean(axis=0)) > 0
        faces = np.where(outward[:, None], faces, faces[:, ::-1])
        if valences(faces, n_vertices).max() <= 10:
            return vertices, _faces(faces)


def cube(levels: int, unevenness: float = 0.0) -> Mesh:
    """Return the cube [-1, 1]³ with 2 ** levels edges along each of its own.

    The vertices are moved along faces and creases by up to ``unevenness`` edges in each direction.
    """
    points = np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
    faces = ConvexHull(points).simplices
    inward = np.linalg.det(points[faces]) < 0
    faces[inward] = faces[inward, ::-1]
    for _ in range(levels):
        points, faces = split_1_to_4(points, faces)
    move = np.random.default_rng(7).uniform(-unevenness, unevenness, points.shape) * 2 / 2**levels
    return points + np.where(np.isclose(np.abs(points), 1), 0, move), faces


def noisy_ball(levels: int = 3, noise: float = 0.01) -> Mesh:
    """Sphere with normally distributed noise in every coordinate."""
    vertices, faces = icosphere(levels)
    return vertices + np.random.default_rng(5).normal(scale=noise, size=vertices.shape), faces


def ellipsoid(levels: int, semi_axes: tuple[float, float, float]) -> Mesh:
    """Return the icosphere scaled along the coordinate axes: a smooth closed shape."""
    vertices, faces = icosphere(levels)
    return vertices * np.asarray(semi_axes), faces


def graded_sphere(levels: int, grading: float = 4.0) -> Mesh:
    """Return a unit sphere whose edges vary smoothly by the ratio ``grading**2`` pole to pole.

    The icosphere under the conformal map z -> ``grading`` z of its stereographic projection.
    """
    vertices, faces = icosphere(levels)
    x, y, z = vertices.T
    # Stereographic projection from the north pole, dilation and its inverse, in one formula.
    squared = grading**2
    denominator = squared * (1 + z) + (1 - z)
    graded = np.stack(
        [
            2 * grading * x / denominator,
            2 * grading * y / denominator,
            (squared * (1 + z) - (1 - z)) / denominator,
        ],
        axis=1,
    )
    return graded, faces


# Open meshes -------------------------------------------------------------------------------------


def single_triangle() -> Mesh:
    """Return one triangle: all edges and vertices are on the boundary."""
    return np.array([(0, 0, 0), (1, 0, 0), (0.3, 0.9, 0)], dtype=float), _faces([(0, 1, 2)])


def flat_grid(n_x: int, n_y: int) -> Mesh:
    """Return a parallelogram of equilateral triangles in z = 0, regular inside."""
    x, y = np.meshgrid(np.arange(n_x + 1), np.arange(n_y + 1), indexing="ij")
    vertices = np.stack([x + 0.5 * y, np.sqrt(0.75) * y, 0.0 * x], axis=-1).reshape(-1, 3)
    index = np.arange(x.size).reshape(x.shape)
    faces = np.concatenate(
        [
            _columns(index[:-1, :-1], index[1:, :-1], index[:-1, 1:]),
            _columns(index[1:, :-1], index[1:, 1:], index[:-1, 1:]),
        ]
    )
    return vertices, faces


def flat_hexagon(n_rings: int) -> Mesh:
    """Return a regular hexagon of edge ``n_rings`` in z = 0, all inner vertices regular."""
    vertices, faces = flat_grid(2 * n_rings, 2 * n_rings)
    x, y = np.divmod(np.arange(len(vertices)), 2 * n_rings + 1)
    inside = np.abs(x + y - 2 * n_rings) <= n_rings
    return keep_faces(vertices, faces, inside[faces].all(axis=1))


def irregular_disc(seed: int, n_rings: int = 3) -> Mesh:
    """Return a flat disc of random connectivity; boundary vertices have 1 to 6 and more faces.

    A hexagon whose inner edges were flipped at random, with one loose ear (a triangle with two
    boundary edges) on a side, laid out without folds by Tutte's embedding in a circle.
    """
    generator = np.random.default_rng(seed)
    vertices, faces = flat_hexagon(n_rings)
    faces = _flip_random_edges(faces, len(vertices), 120, generator)
    loop = boundary_loop(faces)
    ear = len(vertices)
    faces = np.vstack([faces, [(loop[1], loop[0], ear)]]).astype(np.int32)
    loop = boundary_loop(faces)
    angles = 2 * np.pi * np.arange(len(loop)) / len(loop)
    vertices = np.zeros((ear + 1, 3))
    vertices[loop] = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    adjacency = np.zeros((ear + 1, ear + 1))
    start, end = edges_of(faces).T
    adjacency[start, end] = adjacency[end, start] = 1.0
    system = np.diag(adjacency.sum(axis=1)) - adjacency
    system[loop] = np.eye(ear + 1)[loop]
    return np.linalg.solve(system, vertices), faces


def bumpy_disc(seed: int) -> Mesh:
    """Return ``irregular_disc`` lifted out of the plane by a smooth height and some noise."""
    vertices, faces = irregular_disc(seed)
    generator = np.random.default_rng(seed)
    height = 0.3 * np.cos(2 * vertices[:, 0]) * (1 + vertices[:, 1])
    vertices[:, 2] = height + 0.02 * generator.normal(size=len(vertices))
    return vertices, faces


def open_cylinder(n_around: int, n_along: int, radius: float = 1.0, height: float = 2.0) -> Mesh:
    """Return a cylinder around z without caps: two boundary curves."""
    angles = 2 * np.pi * np.arange(n_around)[:, None] / n_around
    levels = height * np.arange(n_along + 1)[None, :] / n_along
    vertices = np.stack(
        [
            radius * np.cos(angles) + 0 * levels,
            radius * np.sin(angles) + 0 * levels,
            levels + 0 * angles,
        ],
        axis=-1,
    ).reshape(-1, 3)
    return vertices, triangles.grid_faces(n_around, n_along + 1, (True, False))


# Tools -------------------------------------------------------------------------------------------


def sliver_prism(n_sides: int, seed: int = 0) -> Mesh:
    """A prism over points of a circle at random angles; its flat ends are zigzags of slivers."""
    angles = np.sort(np.random.default_rng(seed).uniform(0, 2 * np.pi, n_sides))
    columns = np.cos(angles), np.sin(angles)
    vertices = np.concatenate(
        [np.column_stack([*columns, np.full(n_sides, z)]) for z in (-0.5, 0.5)]
    )
    around = np.arange(n_sides)
    beyond = (around + 1) % n_sides
    sides = [(around, beyond, beyond + n_sides), (around, beyond + n_sides, around + n_sides)]
    # 0, 1, n - 1, 2, n - 2 ...: every three in a row are a triangle.
    zigzag = np.zeros(n_sides, dtype=int)
    zigzag[1::2], zigzag[2::2] = around[1 : n_sides // 2 + 1], -around[1 : (n_sides + 1) // 2]
    strip = np.column_stack([zigzag[:-2], zigzag[1:-1], zigzag[2:]]) % n_sides
    strip[::2] = strip[::2, ::-1]
    top = strip[:, ::-1] + n_sides
    faces = np.concatenate([*(np.column_stack(each) for each in sides), strip, top])
    return vertices, faces.astype(np.int32)


def divided(vertices: np.ndarray, faces: np.ndarray, parts: int) -> Mesh:
    """Divide every edge into parts and every triangle, which stays flat, into parts² triangles."""
    second, third = np.array([(i, j) for i in range(parts + 1) for j in range(parts + 1 - i)]).T
    weights = np.column_stack([parts - second - third, second, third]) / parts
    at = {place: index for index, place in enumerate(zip(second, third, strict=True))}
    small = np.array(
        [(at[i, j], at[i + 1, j], at[i, j + 1]) for i, j in at if i + j < parts]
        + [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i, j in at if i + j < parts - 1]
    )
    points = np.einsum("kc,fcx->fkx", weights, vertices[faces]).reshape(-1, 3)
    _, first, same = np.unique(points.round(9), axis=0, return_index=True, return_inverse=True)
    at_face = len(weights) * np.arange(len(faces))[:, None, None]
    return points[first], same.ravel()[(at_face + small).reshape(-1, 3)].astype(np.int32)


def merged(*meshes: Mesh) -> Mesh:
    """Return several meshes as the components of one, in order."""
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    faces = [faces + offset for (_, faces), offset in zip(meshes, offsets[:-1], strict=True)]
    return np.vstack([vertices for vertices, _ in meshes]), np.vstack(faces).astype(np.int32)


def keep_faces(vertices: np.ndarray, faces: np.ndarray, keep: np.ndarray) -> Mesh:
    """Return the faces where ``keep`` is true and the vertices they use, renumbered."""
    used, renumbered = np.unique(faces[keep], return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3).astype(np.int32)


def valences(faces: np.ndarray, n_vertices: int) -> np.ndarray:
    """Return the number of edges at every vertex, (n_vertices,)."""
    return np.bincount(edges_of(faces).ravel(), minlength=n_vertices)


def boundary_loop(faces: np.ndarray) -> np.ndarray:
    """Return the vertices of the only boundary curve, in the direction of its faces."""
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    known = {tuple(edge) for edge in directed.tolist()}
    following = {start: end for start, end in known if (end, start) not in known}
    loop = [min(following)]
    while following[loop[-1]] != loop[0]:
        loop.append(following[loop[-1]])
    return np.array(loop)


def boundary_vertices(faces: np.ndarray) -> np.ndarray:
    """Return the sorted vertices on edges with a single face."""
    edges, counts = np.unique(_sides(faces), axis=0, return_counts=True)
    return np.unique(edges[counts == 1])


def _sides(faces: np.ndarray) -> np.ndarray:
    """Return the sides (0,1), (1,2), (2,0) of all faces, (3 n, 2), lower index first."""
    return np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)


def _flip_random_edges(
    faces: np.ndarray, n_vertices: int, n_tries: int, generator: np.random.Generator
) -> np.ndarray:
    """Flip random inner edges where the mesh stays simplicial and inner valences in 3 ... 10."""
    corners = faces.tolist()
    faces_of: dict[tuple[int, int], list[int]] = {}
    for row, side in enumerate(map(tuple, _sides(faces).tolist())):
        faces_of.setdefault(side, []).append(row % len(faces))
    valence = np.bincount(np.ravel(list(faces_of)), minlength=n_vertices).tolist()
    inner = sorted(side for side, pair in faces_of.items() if len(pair) == 2)
    border = {vertex for side, pair in faces_of.items() if len(pair) == 1 for vertex in side}
    for _ in range(n_tries):
        chosen = inner[generator.integers(len(inner))]
        sides = sorted(
            (k, face)
            for face in faces_of[chosen]
            for k in range(3)
            if corners[face][k - 1] not in chosen
        )
        (a, b, c), (_, _, d) = (corners[face][k:] + corners[face][:k] for k, face in sides)
        across = (min(c, d), max(c, d))
        if (
            across in faces_of
            or any(valence[vertex] <= (2 if vertex in border else 3) for vertex in chosen)
            or max(valence[c], valence[d]) >= 10
        ):
            continue
        (_, first), (_, second) = sides
        corners[first], corners[second] = [a, d, c], [d, b, c]
        for side, old, new in (((b, c), first, second), ((a, d), second, first)):
            pair = faces_of[min(side), max(side)]
            pair[pair.index(old)] = new
        faces_of[across] = faces_of.pop(chosen)
        inner.remove(chosen)
        insort(inner, across)
        for vertex, change in ((a, -1), (b, -1), (c, 1), (d, 1)):
            valence[vertex] += change
    return np.array(corners, dtype=faces.dtype)


def _on_sphere(corners: list[tuple[float, float, float]]) -> np.ndarray:
    vertices = np.array(corners, dtype=float)
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True)


def _faces(faces: list[tuple[int, int, int]]) -> np.ndarray:
    return np.array(faces, dtype=np.int32)


def _columns(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return three index arrays of one shape as the corners of triangles, (n, 3) int32."""
    return np.stack([np.ravel(a), np.ravel(b), np.ravel(c)], axis=1).astype(np.int32)
