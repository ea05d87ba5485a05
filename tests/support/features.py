"""Everything that an object can carry: each feature puts something on an object and reads it back.

Needs bpy.
"""

import bpy
import numpy as np

from adaptive_fairing.blender.data.mesh_arrays import read_positions, write_positions
from adaptive_fairing.blender.data.shape_keys import remove_fairing_keys

from .objects import bumpy_box, corners

VALUES = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, bool),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
}
FEATURES = {}


def feature(make):
    """Enter a feature: `make` puts it on an object and returns a function that reads it."""
    FEATURES[make.__name__] = make
    return make


def fill(attribute, seed=0):
    name, width, kind = VALUES[attribute.data_type]
    size = width * len(attribute.data)
    generator = np.random.default_rng(seed)
    values = generator.integers(0, 2 if kind is bool else 100, size).astype(kind)
    attribute.data.foreach_set(name, values if kind is not np.float32 else values / np.float32(128))


def content(attribute):
    name, width, kind = VALUES[attribute.data_type]
    values = np.zeros(width * len(attribute.data), dtype=kind)
    attribute.data.foreach_get(name, values)
    return (attribute.data_type, attribute.domain, values.tolist())


def flags(elements, name):
    values = np.zeros(len(elements), dtype=bool)
    elements.foreach_get(name, values)
    return values.tolist()


def own_attributes(mesh):
    return {
        a.name: content(a)
        for a in mesh.attributes
        if a.data_type in VALUES and a.name != "position" and "fairing" not in a.name
    }


@feature
def polygons_and_edges(obj):
    return lambda obj: (
        [tuple(polygon.vertices) for polygon in obj.data.polygons],
        [tuple(edge.vertices) for edge in obj.data.edges],
        corners(obj.data).tolist(),
    )


@feature
def loose_vertices_and_edges(obj):
    mesh = obj.data
    mesh.vertices.add(2)
    mesh.vertices[-2].co, mesh.vertices[-1].co = (5, 5, 5), (6, 6, 6)
    mesh.edges.add(1)
    mesh.edges[-1].vertices = (len(mesh.vertices) - 2, len(mesh.vertices) - 1)
    mesh.update()
    return lambda obj: (
        [tuple(edge.vertices) for edge in obj.data.edges],
        read_positions(obj.data)[-2:].tolist(),
    )


@feature
def uv_maps(obj):
    for seed, name in enumerate(("UVMap", "Second")):
        layer = obj.data.uv_layers.new(name=name)
        fill(obj.data.attributes[layer.name], seed)
    obj.data.uv_layers.active = obj.data.uv_layers["Second"]
    obj.data.uv_layers["UVMap"].active_render = True
    return lambda obj: (
        own_attributes(obj.data),
        obj.data.uv_layers.active.name,
        [layer.name for layer in obj.data.uv_layers if layer.active_render],
    )


@feature
def seams(obj):
    obj.data.edges.foreach_set("use_seam", np.arange(len(obj.data.edges)) % 3 == 0)
    return lambda obj: flags(obj.data.edges, "use_seam")


@feature
def sharp_edges(obj):
    obj.data.edges.foreach_set("use_edge_sharp", np.arange(len(obj.data.edges)) % 5 == 0)
    return lambda obj: flags(obj.data.edges, "use_edge_sharp")


@feature
def smooth_shading(obj):
    obj.data.polygons.foreach_set("use_smooth", np.arange(len(obj.data.polygons)) % 2 == 0)
    return lambda obj: flags(obj.data.polygons, "use_smooth")


@feature
def colors(obj):
    for name, kind, domain in [("Corner", "BYTE_COLOR", "CORNER"), ("P", "FLOAT_COLOR", "POINT")]:
        fill(obj.data.color_attributes.new(name, kind, domain))
    return lambda obj: own_attributes(obj.data)


@feature
def attributes_of_all_kinds(obj):
    for kind in VALUES:
        for domain in ("POINT", "EDGE", "FACE", "CORNER"):
            fill(obj.data.attributes.new(f"{kind} {domain}", kind, domain))
    return lambda obj: own_attributes(obj.data)


@feature
def creases_and_bevel_weights(obj):
    for name in ("crease", "bevel_weight"):
        for domain, end in (("POINT", "vert"), ("EDGE", "edge")):
            fill(obj.data.attributes.new(f"{name}_{end}", "FLOAT", domain))
    return lambda obj: own_attributes(obj.data)


@feature
def selection_and_hidden_parts(obj):
    for name, elements in (("select", obj.data.vertices), ("hide", obj.data.polygons)):
        elements.foreach_set(name, np.arange(len(elements)) % 4 == 0)
    return lambda obj: (flags(obj.data.vertices, "select"), flags(obj.data.polygons, "hide"))


@feature
def sculpt_mask_and_face_sets(obj):
    fill(obj.data.attributes.new(".sculpt_mask", "FLOAT", "POINT"))
    fill(obj.data.attributes.new(".sculpt_face_set", "INT", "FACE"))
    return lambda obj: own_attributes(obj.data)


@feature
def custom_normals(obj):
    mesh = obj.data
    generator = np.random.default_rng(0)
    vectors = [corner.vector[:] for corner in mesh.corner_normals]
    tilted = np.array(vectors) + 0.2 * generator.normal(size=(len(vectors), 3))
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    mesh.normals_split_custom_set(tilted.tolist())

    def read(obj):
        # They are stored relative to the surface, so they are compared on the undeformed one.
        copy = obj.copy()
        copy.data = obj.data.copy()
        remove_fairing_keys(copy)
        write_positions(copy.data, bumpy_box()[0])
        normals = [tuple(round(x, 5) for x in each.vector) for each in copy.data.corner_normals]
        return (obj.data.has_custom_normals, normals)

    return read


@feature
def vertex_groups(obj):
    for seed, name in enumerate(("Left", "Right")):
        group = obj.vertex_groups.new(name=name)
        for vertex in range(seed, len(obj.data.vertices), 3):
            group.add([vertex], 1 / (vertex + 1), "REPLACE")
    obj.vertex_groups["Right"].lock_weight = True
    return lambda obj: (
        [(group.name, group.lock_weight) for group in obj.vertex_groups],
        [[(g.group, g.weight) for g in vertex.groups] for vertex in obj.data.vertices],
    )


@feature
def materials(obj):
    for name in ("Red", "Blue"):
        obj.data.materials.append(bpy.data.materials.new(name))
    obj.data.materials.append(None)
    obj.material_slots[1].link = "OBJECT"
    obj.material_slots[1].material = bpy.data.materials.new("Green")
    obj.data.polygons.foreach_set("material_index", np.arange(len(obj.data.polygons)) % 3)
    return lambda obj: (
        [(slot.link, slot.material and slot.material.name) for slot in obj.material_slots],
        [polygon.material_index for polygon in obj.data.polygons],
    )


@feature
def modifiers(obj):
    obj.modifiers.new("Round", "SUBSURF").levels = 2
    mirror = obj.modifiers.new("Mirror", "MIRROR")
    mirror.use_axis = (False, True, False)
    obj.modifiers.new("Off", "SOLIDIFY").show_viewport = False
    return lambda obj: (
        [(m.name, m.type, m.show_viewport) for m in obj.modifiers],
        obj.modifiers["Round"].levels,
        tuple(obj.modifiers["Mirror"].use_axis),
    )


@feature
def armature(obj):
    skeleton = bpy.data.objects.new("Skeleton", bpy.data.armatures.new("Skeleton"))
    bpy.context.scene.collection.objects.link(skeleton)
    obj.modifiers.new("Armature", "ARMATURE").object = skeleton
    obj.parent = skeleton
    return lambda obj: (obj.modifiers["Armature"].object.name, obj.parent.name)


@feature
def parents_and_children(obj):
    for name in ("Parent", "Child"):
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, None))
    parent, child = bpy.data.objects["Parent"], bpy.data.objects["Child"]
    parent.location = (1, 2, 3)
    bpy.context.view_layer.update()
    obj.parent = parent
    obj.matrix_parent_inverse = parent.matrix_world.inverted()
    child.parent = obj
    child.parent_type, child.parent_vertices = "VERTEX_3", (1, 5, 9)
    return lambda obj: (
        obj.parent.name,
        [tuple(row) for row in obj.matrix_parent_inverse],
        [(c.name, c.parent_type, tuple(c.parent_vertices)) for c in obj.children],
    )


@feature
def transform_and_locks(obj):
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.1, 0.2, 0.3), (1, -2, 0.5)
    obj.lock_location[1] = True
    obj.pass_index = 7
    return lambda obj: (
        [tuple(row) for row in obj.matrix_world],
        tuple(obj.lock_location),
        obj.pass_index,
    )


@feature
def drivers(obj):
    obj.data["size"] = 1.0
    for owner, path, index in ((obj, "location", 2), (obj.data, '["size"]', -1)):
        driver = owner.driver_add(path, index) if index >= 0 else owner.driver_add(path)
        driver.driver.expression = "frame * 0.25"
    return lambda obj: [
        [(d.data_path, d.array_index, d.driver.expression) for d in owner.animation_data.drivers]
        for owner in (obj, obj.data)
    ]


@feature
def animation_and_constraints(obj):
    obj.location = (3, 0, 0)
    obj.keyframe_insert("location", frame=5)
    obj.constraints.new("LIMIT_SCALE").use_max_x = True
    return lambda obj: (
        obj.animation_data.action.name,
        [(c.type, c.use_max_x) for c in obj.constraints],
    )


@feature
def custom_properties(obj):
    obj["note"], obj.data["note"] = "object", [1, 2, 3]
    return lambda obj: (obj["note"], list(obj.data["note"]))


@feature
def collections_and_visibility(obj):
    other = bpy.data.collections.new("Other")
    bpy.context.scene.collection.children.link(other)
    other.objects.link(obj)
    obj.display_type, obj.show_wire, obj.color = "BOUNDS", True, (1, 0.5, 0.25, 1)
    return lambda obj: (
        sorted(collection.name for collection in obj.users_collection),
        (obj.display_type, obj.show_wire, tuple(obj.color)),
        (obj.hide_render, obj.hide_viewport),
    )


@feature
def names_and_users(obj):
    obj.data.name = "Shape"
    obj.data.use_fake_user = True
    return lambda obj: (obj.name, obj.data.name, obj.data.use_fake_user)
