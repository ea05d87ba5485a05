"""Painting back: the overlay is faint while somebody paints, X swaps the weights 0 and 1."""

import bpy
import pytest
from support.fields import views

from adaptive_fairing.blender.compatibility import weight_paint_settings
from adaptive_fairing.blender.operators.painting import FAINT, is_painting

pytestmark = pytest.mark.usefixtures("addon")


def paint():
    return bpy.ops.object.adaptive_fairing_paint()


def swap():
    return bpy.ops.object.adaptive_fairing_paint_swap()


def opacities():
    return [space.overlay.weight_paint_mode_opacity for space in views()]


@pytest.fixture
def denoised(noisy):
    bpy.ops.object.adaptive_fairing()
    return noisy


def by_button(obj):
    paint()


def by_mode(obj):
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()


def by_another_group(obj):
    obj.vertex_groups.active = obj.vertex_groups.new(name="Mine")
    obj.data.update()
    bpy.context.view_layer.update()


@pytest.mark.parametrize("end", [by_button, by_mode, by_another_group])
def test_the_overlay_is_faint_as_long_as_somebody_paints(denoised, end):
    views()[0].overlay.weight_paint_mode_opacity = 0.7
    before = opacities()
    assert len(set(before)) > 1
    paint()
    assert opacities() == pytest.approx([FAINT] * len(before))
    end(denoised)
    bpy.context.view_layer.update()
    assert opacities() == before


def test_what_somebody_sets_meanwhile_stays(denoised):
    paint()
    views()[0].overlay.weight_paint_mode_opacity = 0.5
    paint()
    bpy.context.view_layer.update()
    assert opacities()[0] == 0.5
    assert FAINT not in opacities()


def test_a_key_swaps_0_and_1(denoised):
    paint()
    settings = weight_paint_settings(bpy.context)
    assert settings.weight == 0.0
    swap()
    assert settings.weight == 1.0
    swap()
    assert settings.weight == 0.0
    settings.weight = 0.3
    swap()
    assert settings.weight == 1.0


def test_other_weights_are_not_swapped(denoised):
    with pytest.raises(RuntimeError, match="while you paint the vertex group Fairing"):
        swap()
    denoised.vertex_groups.new(name="Mine")
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    assert not is_painting(bpy.context)
    paint()
    assert denoised.mode == "OBJECT"


def test_in_sculpt_mode_the_button_needs_a_mask(denoised):
    bpy.ops.object.mode_set(mode="SCULPT")
    assert not bpy.ops.object.adaptive_fairing_paint.poll()
    bpy.ops.object.mode_set(mode="OBJECT")
    denoised.data.attributes.new(".sculpt_mask", "FLOAT", "POINT")
    bpy.ops.object.mode_set(mode="SCULPT")
    assert bpy.ops.object.adaptive_fairing_paint.poll()
    with pytest.raises(RuntimeError, match="Mask where the original is to come back"):
        paint()  # nothing is masked
