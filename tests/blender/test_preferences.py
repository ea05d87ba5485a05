"""Preferences of the add-on: what new files begin with, and the processors of a run."""

from types import SimpleNamespace

import bpy
import pytest
from support.layouts import FakeLayout
from support.meshes import noisy_ball
from support.objects import add_object

from adaptive_fairing.blender.preferences import FairingPreferences, addon_name, preferences
from adaptive_fairing.core.runtime.threads import limit_threads, n_threads

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def wanted():
    """Preferences as of an add-on that was enabled in Blender's own preferences."""
    entry = bpy.context.preferences.addons.new()
    entry.module = addon_name()
    yield preferences()
    bpy.context.preferences.addons.remove(entry)


def settings():
    return bpy.context.scene.adaptive_fairing


def new_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def test_without_an_entry_in_blenders_preferences_there_are_none():
    assert preferences() is None
    new_file()
    assert (settings().algorithm, settings().result) == ("DENOISE", "LIVE")


def test_a_new_file_begins_with_them(wanted):
    wanted.algorithm, wanted.result = "FAIR", "MODIFIER"
    new_file()
    assert (settings().algorithm, settings().result) == ("FAIR", "MODIFIER")
    wanted.algorithm = "DENOISE"
    new_file()
    assert (settings().algorithm, settings().result) == ("DENOISE", "MODIFIER")


def test_the_open_file_follows_what_was_changed_alone(wanted):
    settings().result = "MODIFIER"
    wanted.algorithm = "FAIR"
    assert (settings().algorithm, settings().result) == ("FAIR", "MODIFIER")


def test_a_file_keeps_what_was_chosen_in_it(wanted, tmp_path):
    path = str(tmp_path / "chosen.blend")
    settings().algorithm = "DENOISE"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    wanted.algorithm, wanted.result = "FAIR", "MODIFIER"
    bpy.ops.wm.open_mainfile(filepath=path)
    assert (settings().algorithm, settings().result) == ("DENOISE", "MODIFIER")


def test_scripts_are_not_changed_by_them(wanted):
    wanted.algorithm, wanted.result = "FAIR", "MODIFIER"
    obj = add_object(*noisy_ball(3, 0.02))
    obj.select_set(True)
    bpy.ops.object.adaptive_fairing()
    assert obj.adaptive_fairing.result == "LIVE"


def test_a_run_heeds_the_threads(wanted):
    add_object(*noisy_ball(2, 0.02)).select_set(True)
    wanted.threads = 1
    try:
        bpy.ops.object.adaptive_fairing()
        assert n_threads() == 1
    finally:
        limit_threads(0)


@pytest.mark.parametrize(("threads", "texts"), [(0, ["Automatic"]), (4, [])])
def test_all_of_them_are_drawn(wanted, threads, texts):
    layout = FakeLayout()
    rna = FairingPreferences.bl_rna
    layout_owner = SimpleNamespace(layout=layout, bl_rna=rna, threads=threads)
    FairingPreferences.draw(layout_owner, bpy.context)
    assert layout.drawn.properties == list(FairingPreferences.__annotations__)
    assert layout.drawn.texts == texts
