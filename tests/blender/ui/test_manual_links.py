"""Every button and field has its place in the manual, and Blender finds it."""

import tomllib

import bpy
import pytest
from bl_operators.wm import WM_OT_doc_view_manual
from support.pages import ROOT, anchors

from adaptive_fairing.blender.data.record_properties import N_SWATCHES, FairingRecord, swatch_name
from adaptive_fairing.blender.preferences import DEFAULTS, FairingPreferences
from adaptive_fairing.blender.properties import FairingSceneSettings
from adaptive_fairing.blender.ui import manual

pytestmark = pytest.mark.usefixtures("addon")


def settings():
    found = bpy.types.Scene.bl_rna.properties["adaptive_fairing"].fixed_type.properties.keys()
    return [
        *(f"bpy.types.{FairingSceneSettings.__name__}.{name}" for name in found),
        *(f"bpy.types.{FairingPreferences.__name__}.{name}" for name in (*DEFAULTS, "threads")),
    ]


def operators():
    found = [name for name in dir(bpy.ops.object) if name.startswith("adaptive_fairing")]
    return [f"bpy.ops.object.{name}" for name in found]


def shown_of_a_result():
    """What a person may point at; the rest of the record is never drawn."""
    shown = ("strength", "evolution", *map(swatch_name, range(N_SWATCHES)))
    return [f"bpy.types.{FairingRecord.__name__}.{name}" for name in shown]


def test_every_operator_and_setting_leads_to_a_heading_of_the_manual():
    names = [*operators(), *settings(), *shown_of_a_result()]
    names = [name for name in names if not name.endswith((".rna_type", ".name"))]
    assert len(names) > 40
    for name in names:
        address = WM_OT_doc_view_manual._lookup_rna_url(name, verbose=False)
        assert (address or "").startswith(manual.MANUAL), f"{name} has no place in our manual"
        page, _, anchor = address.removeprefix(manual.MANUAL).partition("/#")
        assert anchor in anchors(ROOT / "docs" / f"{page}.md"), f"{name}: no {page}.md#{anchor}"


def test_every_place_belongs_to_an_operator_or_a_property():
    known = {name.lower() for name in (*operators(), *settings(), *shown_of_a_result())}
    _, pages = manual.manual_pages()
    for pattern, _ in pages:
        assert any(name.startswith(pattern.rstrip("*")) for name in known), pattern


def test_the_address_is_the_manifests():
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    assert f"{manifest['website']}#" == manual.MANUAL
