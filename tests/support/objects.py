"""Blender objects for tests, and what a test asks of them. Needs bpy."""

import bpy
import numpy as np

from adaptive_fairing.blender.data.mesh_arrays import read_attributes, read_mesh_coordinates
from adaptive_fairing.blender.files.mesh_files import empty_scene, export_mesh

GRID = 5


def add_object(vertices, faces, name="Thing"):
    """Add a mesh object of any polygons to the scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices).tolist(), [], [list(map(int, face)) for face in faces])
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    return obj


def write_ply(path, vertices, faces):
    """Write a mesh as the only one of a scene; give its path."""
    empty_scene()
    export_mesh(add_object(vertices, faces), path, alone=True)
    return path


def bumpy_box():
    """Make a closed box of quads with one hexagon and noise: (vertices, polygons)."""
    rng = np.random.default_rng(7)
    index, vertices, polygons = {}, [], []

    def corner(point):
        if point not in index:
            index[point] = len(vertices)
            vertices.append(np.array(point) / 3 + rng.normal(scale=0.02, size=3))
        return index[point]

    for axis in range(3):
        for side in (0, GRID):
            for i in range(GRID):
                for j in range(GRID):
                    square = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        point = [0, 0, 0]
                        point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = side, a, b
                        square.append(corner(tuple(point)))
                    polygons.append(square if side else square[::-1])
    joined = _join(polygons[0], polygons[1])
    return np.array(vertices), [joined, *polygons[2:]]


def add_rich_object(name="Thing"):
    """Add the bumpy box with UVs, two kinds of colours, a number and two materials."""
    obj = add_object(*bumpy_box(), name=name)
    mesh = obj.data
    rng = np.random.default_rng(3)
    # One UV per vertex: what every format can hold.
    by_vertex = rng.random((len(mesh.vertices), 2), dtype=np.float32)
    uv = mesh.uv_layers.new(name="UVMap")
    uv.uv.foreach_set("vector", by_vertex[corners(mesh)].ravel())
    colors = np.ones((len(mesh.vertices), 4), dtype=np.float32)
    colors[:, :3] = np.round(255 * rng.random((len(mesh.vertices), 3))) / 255
    color = mesh.color_attributes.new("Paint", "BYTE_COLOR", "POINT")
    color.data.foreach_set("color_srgb", colors.ravel())
    mesh.color_attributes.active_color = color
    number = mesh.attributes.new("heat", "FLOAT", "POINT")
    number.data.foreach_set("value", rng.random(len(mesh.vertices), dtype=np.float32))
    for material in ("Red", "Blue"):
        mesh.materials.append(bpy.data.materials.new(material))
    mesh.polygons.foreach_set("material_index", np.arange(len(mesh.polygons)) % 2)
    mesh.update()
    return obj


def corners(mesh):
    """Vertex of every corner."""
    found = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", found)
    return found


def polygons_of(mesh):
    """Polygons as tuples of vertices."""
    return [tuple(polygon.vertices) for polygon in mesh.polygons]


def uvs_by_corner(mesh):
    """UV of every corner of every polygon: {(polygon's vertices): ((u, v), ...)}."""
    uv = np.empty(2 * len(mesh.loops), dtype=np.float32)
    mesh.uv_layers.active.uv.foreach_get("vector", uv)
    uv = uv.reshape(-1, 2)
    return {
        tuple(polygon.vertices): uv[polygon.loop_start : polygon.loop_start + len(polygon.vertices)]
        for polygon in mesh.polygons
    }


def colors_by_vertex(mesh, name):
    """Colour of every vertex in sRGB, (n, 4), from a point or a corner attribute."""
    attribute = mesh.color_attributes[name]
    flat = np.empty(4 * len(attribute.data), dtype=np.float32)
    attribute.data.foreach_get("color_srgb", flat)
    colors = flat.reshape(-1, 4)
    if attribute.domain == "POINT":
        return colors
    by_vertex = np.empty((len(mesh.vertices), 4), dtype=np.float32)
    by_vertex[corners(mesh)] = colors
    return by_vertex


def numbers(mesh, name):
    """Values of a float attribute."""
    attribute = mesh.attributes[name]
    values = np.empty(len(attribute.data), dtype=np.float32)
    attribute.data.foreach_get("value", values)
    return values


def materials_by_polygon(mesh):
    """Name of the material of every polygon."""
    return {
        tuple(polygon.vertices): mesh.materials[polygon.material_index].name
        for polygon in mesh.polygons
    }


def everything(obj):
    """Return all that a mesh is, to be compared bit by bit."""
    mesh = obj.data
    found = {
        array.name: (array.data_type, array.domain, array.values.tolist())
        for array in read_attributes(mesh)
        if not array.name.startswith(".select")
    }
    found["coordinates"] = read_mesh_coordinates(mesh).tobytes()
    found["corners"] = [tuple(polygon.vertices) for polygon in mesh.polygons]
    found["edges"] = [tuple(edge.vertices) for edge in mesh.edges]
    found["materials"] = [material.name for material in mesh.materials]
    found["groups"] = [
        (group.name, [[(e.group, e.weight) for e in v.groups] for v in mesh.vertices])
        for group in obj.vertex_groups
    ]
    keys = mesh.shape_keys
    found["keys"] = None
    if keys is not None:
        found["keys"] = [
            (b.name, b.value, key_positions(obj, b.name).tobytes()) for b in keys.key_blocks
        ]
    return found


def shown_positions(obj):
    """Positions as the viewport shows them: shape keys and modifiers applied, in object space."""
    graph = bpy.context.evaluated_depsgraph_get()
    graph.update()
    mesh = obj.evaluated_get(graph).data
    flat = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def world_positions(obj):
    """Positions as the viewport shows them, in the world."""
    matrix = np.array(obj.matrix_world)
    return shown_positions(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def keyframe_motion(obj, frame, amount):
    """Let an object be moved and turned at a frame, the more the larger the amount."""
    obj.location = (amount, 2 * amount, 0.5)
    obj.keyframe_insert("location", frame=frame)
    obj.rotation_euler = (0, 0, amount)
    obj.keyframe_insert("rotation_euler", frame=frame)


def select(obj, chosen):
    """Select vertices for Edit Mode."""
    # As attributes: setting "select" of an edge that never had one crashes Blender.
    attributes = obj.data.attributes
    for name, domain in (
        (".select_vert", "POINT"),
        (".select_edge", "EDGE"),
        (".select_poly", "FACE"),
    ):
        if name in attributes:
            attributes.remove(attributes[name])
        attributes.new(name, "BOOLEAN", domain)
    attributes[".select_vert"].data.foreach_set("value", np.asarray(chosen, dtype=bool))


def edit_net(obj, how):
    """Subdivide the active object in Edit Mode, or delete a vertex there."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT" if how == "subdivide" else "DESELECT")
    if how == "subdivide":
        bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")
    if how == "delete":
        obj.data.vertices[7].select = True
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.delete(type="VERT")
        bpy.ops.object.mode_set(mode="OBJECT")


def edited_vertices(obj):
    """Vertices of an object in Edit Mode."""
    import bmesh  # only there once bpy is

    vertices = bmesh.from_edit_mesh(obj.data).verts
    vertices.ensure_lookup_table()
    return vertices


def key_positions(obj, name):
    """Positions of a shape key."""
    block = obj.data.shape_keys.key_blocks[name]
    flat = np.empty(3 * len(obj.data.vertices), dtype=np.float32)
    block.points.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def _join(first, second):
    """Make one polygon of two that share an edge."""
    for at, vertex in enumerate(first):
        following = first[(at + 1) % len(first)]
        if vertex in second and following in second:
            turned = first[at + 1 :] + first[: at + 1]  # starts behind the shared edge's start
            start = second.index(vertex)
            path = second[start:] + second[:start]
            return [*turned, *path[1 : len(path) - 1]]
    raise ValueError("the polygons have no edge in common")
