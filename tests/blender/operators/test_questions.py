"""Confirmation before changes that cannot be undone, with everything that will change."""

from types import SimpleNamespace

import bpy
import pytest
from support.layouts import FakeContext, FakeLayout
from support.meshes import noisy_ball
from support.objects import add_object

from adaptive_fairing.blender.operators import fair, loop_subdivide, results
from adaptive_fairing.blender.operators.questions import Asking

pytestmark = pytest.mark.usefixtures("addon")

ASKING = [
    fair.OBJECT_OT_adaptive_fairing,
    results.OBJECT_OT_adaptive_fairing_apply,
    results.OBJECT_OT_adaptive_fairing_discard,
    loop_subdivide.OBJECT_OT_adaptive_fairing_loop_subdivide,
]


class Window(FakeContext):
    """A context in which undo is on or off, and that keeps the menu that is opened."""

    def __init__(self, *, has_undo):
        self.preferences = SimpleNamespace(edit=SimpleNamespace(use_global_undo=has_undo))
        self.window_manager = SimpleNamespace(popup_menu=self._open)
        self.menu = None

    def _open(self, draw, *, title, icon):
        self.menu = SimpleNamespace(layout=FakeLayout())
        self.menu.layout.drawn.texts.append(title)
        draw(self.menu, self)


def stand_in(operator, **given):
    """Make an object with the functions of an operator, as Blender would after a click."""
    properties = SimpleNamespace(
        bl_rna=bpy.ops.object.adaptive_fairing.get_rna_type(),
        is_property_set=lambda name: name in {"rna_type", *given},
        **given,
    )
    class_ = type("StandIn", (), {**vars_of(operator), "properties": properties})
    made = class_()
    for name, value in {
        "is_confirmed": False,
        "algorithm": "DENOISE",
        "result": "LIVE",
        "output": "ABSOLUTE_KEYS",
        **given,
    }.items():
        setattr(made, name, value)
    made.from_original = False
    made.execute = lambda context: {"FINISHED"}
    return made


def vars_of(operator):
    return {"bl_idname": operator.bl_idname, "bl_label": operator.bl_label} | {
        "ask": Asking.ask,
        "invoke": operator.invoke,
    }


@pytest.mark.parametrize("operator", ASKING[1:], ids=lambda each: each.__name__)
class TestWithoutUndo:
    def test_a_click_opens_a_question_and_changes_nothing(self, operator):
        context = Window(has_undo=False)
        assert stand_in(operator).invoke(context, None) == {"CANCELLED"}
        drawn = context.menu.layout.drawn
        assert drawn.texts == ["Undo is turned off: this cannot be undone"]
        (answer,) = drawn.operators
        assert answer["name"] == operator.bl_idname
        assert answer["is_confirmed"]

    def test_the_answer_is_not_asked_again(self, operator):
        context = Window(has_undo=False)
        assert stand_in(operator, is_confirmed=True).invoke(context, None) == {"FINISHED"}
        assert context.menu is None

    def test_with_undo_nothing_is_asked(self, operator):
        context = Window(has_undo=True)
        assert stand_in(operator).invoke(context, None) == {"FINISHED"}
        assert context.menu is None


def test_a_run_says_what_else_it_changes_and_keeps_its_settings():
    obj = add_object(*noisy_ball(2, 0.02))
    obj.select_set(True)
    obj.scale = (1.0, 1.0, 3.0)
    context = Window(has_undo=False)
    run = stand_in(ASKING[0], algorithm="FAIR", steps=7, tau=0.25)
    assert run.invoke(context, None) == {"CANCELLED"}
    drawn = context.menu.layout.drawn
    assert drawn.texts[1:] == ["The scale is not uniform: apply it first"]
    (answer,) = drawn.operators
    assert answer["text"] == "Fair"
    given = {name: answer[name] for name in ("algorithm", "steps", "tau", "is_confirmed")}
    assert given == {"algorithm": "FAIR", "steps": 7, "tau": 0.25, "is_confirmed": True}


def test_scripts_are_not_asked():
    add_object(*noisy_ball(3, 0.02)).select_set(True)
    bpy.context.preferences.edit.use_global_undo = False
    try:
        assert bpy.ops.object.adaptive_fairing() == {"FINISHED"}
        assert bpy.ops.object.adaptive_fairing_discard() == {"FINISHED"}
    finally:
        bpy.context.preferences.edit.use_global_undo = True
