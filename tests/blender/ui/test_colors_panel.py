"""The panel of the colours: its legend in the units of the scene, and its buttons."""

import bpy
import numpy as np
import pytest
from support.layouts import draw
from support.meshes import graded_sphere
from support.objects import add_object

from adaptive_fairing.blender.ui import colors_panel

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def sphere():
    """A sphere with a dense side, twice as large in the world as its mesh."""
    vertices, faces = graded_sphere(2)
    obj = add_object(vertices, faces)
    obj.scale = (2.0, 2.0, 2.0)
    obj.select_set(True)
    bpy.context.view_layer.update()
    bpy.context.scene.adaptive_fairing.density_passes = 0
    return obj


def drawn():
    return draw(colors_panel.VIEW3D_PT_adaptive_fairing_view)


def edge_lengths(vertices, faces):
    """Mean length of the edges at every vertex of a closed mesh, one by one."""
    edges = {tuple(sorted(edge)) for a, b, c in faces.tolist() for edge in ((a, b), (b, c), (c, a))}
    lengths = [[] for _ in vertices]
    for a, b in edges:
        for end in (a, b):
            lengths[end].append(np.linalg.norm(vertices[a] - vertices[b]))
    return np.array([np.mean(each) for each in lengths])


def areas(vertices, faces):
    """Area of the triangles around every vertex, one by one."""
    sums = np.zeros(len(vertices))
    for corners in faces:
        a, b, c = vertices[corners]
        sums[corners] += 0.5 * np.linalg.norm(np.cross(b - a, c - a))
    return sums


class TestDensity:
    @pytest.mark.parametrize("system", ["NONE", "METRIC", "IMPERIAL"])
    @pytest.mark.parametrize("kind", ["EDGE", "AREA"])
    def test_it_is_a_length_or_an_area_of_the_world(self, sphere, system, kind):
        scene = bpy.context.scene
        scene.unit_settings.system, scene.unit_settings.scale_length = system, 0.01
        scene.adaptive_fairing.density = kind
        bpy.ops.object.adaptive_fairing_view(field="DENSITY")
        title, *values = drawn().texts[:6]
        power = 1 if kind == "EDGE" else 2
        measured = {"EDGE": edge_lengths, "AREA": areas}[kind](*graded_sphere(2))
        assert title == {1: "Mean edge length", 2: "Area of the triangles"}[power] + " at a vertex"
        assert values[0].endswith("  coarse")
        assert values[-1].endswith("  dense")
        unit, shown = 1.0, [text.split("  ")[0] for text in values]
        if system == "NONE":
            shown = list(map(float, shown))
        else:
            unit, category = 0.01, {1: "LENGTH", 2: "AREA"}[power]
            shown = [bpy.utils.units.to_value(system, category, text) for text in shown]
        assert shown == sorted(shown, reverse=True)
        expected = measured * (2.0 * unit) ** power
        low, high = np.percentile(expected, (1, 99))
        # Three digits are drawn, of a mesh in single precision.
        assert shown[-1] == pytest.approx(low, rel=6e-3)
        assert shown[0] == pytest.approx(high, rel=6e-3)


class TestButtons:
    def test_the_lit_button_ends_the_view(self, sphere):
        bpy.ops.object.adaptive_fairing_view(field="DENSITY")
        (pressed,) = [each for each in drawn().operators if each["depress"]]
        assert (pressed["name"], pressed["text"]) == ("object.adaptive_fairing_view_end", "Density")

    def test_the_material_is_offered_and_taken_back(self, sphere):
        assert drawn().operators[-1]["name"] == "object.adaptive_fairing_material"
        bpy.ops.object.adaptive_fairing_material()
        assert drawn().operators[-1]["name"] == "object.adaptive_fairing_material_end"
        bpy.ops.object.adaptive_fairing_material_end()
        assert drawn().operators[-1]["name"] == "object.adaptive_fairing_material"


@pytest.mark.parametrize(
    ("system", "unit", "length"),
    [("NONE", "unit", 1.0), ("METRIC", "m", 0.5), ("IMPERIAL", "ft", 0.5 / 0.3048)],
)
def test_curvatures_have_their_units(sphere, system, unit, length):
    """`length` is what Blender's unit is worth."""
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length = system, 0.5
    for field, power, ending in (("CURVATURE", 1, unit), ("GAUSSIAN", 2, f"{unit}²")):
        bpy.ops.object.adaptive_fairing_view(field=field)
        high = sphere.adaptive_fairing.view_range[1] / (2.0 * length) ** power
        assert drawn().texts[0] == f"{high:.3g} / {ending}"
