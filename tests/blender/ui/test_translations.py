"""Translations: every text of the interface has one, with the same placeholders."""

import ast
import re
import string
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest

from adaptive_fairing.blender.preferences import FairingPreferences
from adaptive_fairing.blender.ui import translations

pytestmark = pytest.mark.usefixtures("addon")

SOURCES = sorted(Path(translations.__file__).parents[1].rglob("*.py"))


def texts_of_blenders_classes():
    """Names and tooltips of operators, panels and properties."""
    texts = set()
    for name in dir(bpy.types):
        found = getattr(bpy.types, name)
        if "adaptive_fairing" in name and issubclass(found, bpy.types.Panel | bpy.types.Operator):
            texts |= {found.bl_label, getattr(found, "bl_description", "")}
    names = [name for name in dir(bpy.ops.object) if name.startswith("adaptive_fairing")]
    kinds = [getattr(bpy.ops.object, name).get_rna_type() for name in names if "preset" not in name]
    kinds.append(bpy.types.Scene.bl_rna.properties["adaptive_fairing"].fixed_type)
    kinds.append(SimpleNamespace(properties=own_properties(FairingPreferences)))
    for kind in kinds:
        for each in kind.properties:
            if each.identifier not in ("rna_type", "name"):
                texts |= {each.name, each.description}
                for item in getattr(each, "enum_items", ()):
                    texts |= {item.name, item.description}
    return texts


def own_properties(kind):
    """Properties of a class, without those that all of Blender's classes of its kind have."""
    return [kind.bl_rna.properties[name] for name in kind.__annotations__]


def texts_of_the_source():
    """Literals that are translated, drawn as a text, or said by a poll."""
    texts = set()
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Call):
                function = getattr(node.func, "id", getattr(node.func, "attr", ""))
                if function in ("iface_", "rpt_", "data_", "tip_"):
                    texts |= literals(node.args[:1])
                texts |= literals(word.value for word in node.keywords if word.arg == "text")
            if isinstance(node, ast.FunctionDef) and re.fullmatch("poll|(.*_)?refusal", node.name):
                found = literals(ast.walk(ast.Module(node.body, [])))
                texts |= {
                    text
                    for text in found
                    if " " in text and text != ast.get_docstring(node, clean=False)
                }
    return texts


def literals(nodes):
    return {
        node.value
        for node in nodes
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def test_every_translation_has_a_text_in_the_source():
    package = Path(translations.__file__).parents[2]
    own = Path(translations.__file__).name
    found = set()
    for path in package.rglob("*.py"):
        if path.name != own:
            found |= literals(ast.walk(ast.parse(path.read_text("utf-8"))))
    assert set(translations.GERMAN) - found == set()


def placeholders(text):
    return [(name, form, conversion) for _, name, form, conversion in _parsed(text)]


def _parsed(text):
    return [part for part in string.Formatter().parse(text) if part[1] is not None]


def in_words(texts):
    return {text for text in texts if re.search(r"\w", text)}


def test_every_name_and_tooltip_is_translated():
    assert in_words(texts_of_blenders_classes()) - set(translations.GERMAN) == set()


def test_every_text_of_the_source_is_translated():
    texts = texts_of_the_source()
    assert len(texts) > 40
    assert in_words(texts) - set(translations.GERMAN) == set()


@pytest.mark.parametrize("english", translations.GERMAN)
def test_placeholders_are_the_same(english):
    assert placeholders(translations.GERMAN[english]) == placeholders(english)


def test_tooltips_have_no_full_stop_in_german_either():
    for english, german in translations.GERMAN.items():
        assert german.endswith(".") == english.endswith("."), english
