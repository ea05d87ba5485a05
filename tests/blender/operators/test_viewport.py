"""While a field is shown 3D views are solid and lit, in colours; after it they are as before."""

import bpy
import pytest
from support.fields import ENDS, add_denoised, shadings, show, views
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.operators import viewport

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    return add_denoised()


each_end = pytest.mark.parametrize("end", ENDS.values(), ids=ENDS)


def test_solid_views_show_the_lit_colours_and_others_stay(obj):
    before = shadings()
    show()
    for was, now in zip(before, shadings(), strict=True):
        assert now == (("SOLID", "VERTEX", "STUDIO") if was[0] == "SOLID" else was)


@each_end
def test_it_comes_back(obj, end):
    first, second = views()[:2]
    first.shading.light = "FLAT"
    before = shadings()
    assert first.shading.show_specular_highlight and second.shading.show_specular_highlight
    assert {"TEXTURE", "MATERIAL"} <= {color for _, color, _ in before}
    show("REMOVED")
    show("DENSITY")
    assert not first.shading.show_specular_highlight
    end()
    bpy.context.view_layer.update()
    assert shadings() == before
    assert first.shading.show_specular_highlight and second.shading.show_specular_highlight


def test_it_comes_back_when_the_object_is_deleted(obj):
    before = shadings()
    show()
    bpy.data.objects.remove(obj)
    bpy.context.view_layer.update()
    assert shadings() == before


def test_what_was_changed_in_the_meantime_stays(obj):
    show()
    shading = views()[0].shading
    shading.type, shading.light = "WIREFRAME", "FLAT"
    bpy.ops.object.adaptive_fairing_view_end()
    assert (shading.type, shading.color_type, shading.light) == (
        "WIREFRAME",
        "MATERIAL",
        "FLAT",
    )


def test_another_field_is_lit_again_and_the_first_shading_comes_back(obj):
    shading = views()[0].shading
    shading.light = "MATCAP"
    show()
    shading.light = "FLAT"
    show("REMOVED")
    assert shading.light == "STUDIO"
    bpy.ops.object.adaptive_fairing_view_end()
    assert shading.light == "MATCAP"


def test_it_stays_while_another_object_shows_a_field(obj):
    other = add_object(*icosphere(1))
    other.select_set(True)
    show()
    obj.select_set(False)
    bpy.data.objects.remove(other)
    bpy.context.view_layer.update()
    assert ("SOLID", "VERTEX", "STUDIO") in shadings()


def test_a_file_saved_with_colours_shows_them_and_is_plain_after_them(obj, tmp_path):
    show()
    path = str(tmp_path / "shown.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    assert "VERTEX" not in {color for _, color, _ in shadings()}
    bpy.ops.wm.open_mainfile(filepath=path)
    assert ("SOLID", "VERTEX", "STUDIO") in shadings()
    bpy.ops.object.adaptive_fairing_view_end()
    assert "VERTEX" not in {color for _, color, _ in shadings()}


def test_a_file_loaded_into_the_same_windows_finds_them_as_they_were(obj, tmp_path):
    path = str(tmp_path / "plain.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    before = shadings()
    show()
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)
    assert shadings() == before


def test_a_linked_object_that_was_saved_with_colours_does_not_hold_it(obj, tmp_path):
    show()
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {obj})
    bpy.ops.object.adaptive_fairing_view_end()
    before = shadings()
    with bpy.data.libraries.load(path, link=True) as (source, target):
        target.objects = source.objects
    assert target.objects[0].adaptive_fairing.view == "DENSITY"
    show()
    bpy.ops.object.adaptive_fairing_view_end()
    assert shadings() == before


def test_without_the_addon_it_is_as_before(obj, addon):
    before = shadings()
    show()
    viewport.unregister()
    assert shadings() == before
