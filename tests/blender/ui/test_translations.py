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

LANGUAGES = translations.languages()
each_language = pytest.mark.parametrize("code", LANGUAGES)

SOURCES = sorted(Path(translations.__file__).parents[2].rglob("*.py"))


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
                    texts |= literals(ast.walk(node.args[0]))
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


def placeholders(text):
    return [(name, form, conversion) for _, name, form, conversion in _parsed(text)]


def _parsed(text):
    return [part for part in string.Formatter().parse(text) if part[1] is not None]


def in_words(texts):
    return {text for text in texts if re.search(r"\w", text)}


def used_texts():
    """Every literal of the source: a key that is none of them is never looked up."""
    trees = [ast.parse(path.read_text("utf-8")) for path in SOURCES]
    return set().union(*(literals(ast.walk(tree)) for tree in trees))


@each_language
def test_every_name_and_tooltip_is_translated(code):
    assert in_words(texts_of_blenders_classes()) - set(LANGUAGES[code]) == set()


@each_language
def test_every_text_of_the_source_is_translated(code):
    texts = texts_of_the_source()
    assert len(texts) > 40
    assert in_words(texts) - set(LANGUAGES[code]) == set()


@each_language
def test_every_text_is_used_in_the_source(code):
    assert set(LANGUAGES[code]) - used_texts() == set()


@each_language
def test_a_language_has_the_texts_of_every_other(code):
    """Also those that the source puts together or looks up by a variable."""
    everywhere = set().union(*LANGUAGES.values())
    assert everywhere - set(LANGUAGES[code]) == set()


@each_language
def test_placeholders_are_the_same(code):
    for english, text in LANGUAGES[code].items():
        assert placeholders(text) == placeholders(english), english


@each_language
def test_texts_end_like_the_english_ones(code):
    """Tooltips have no full stop: Blender adds it. Spaces and ellipses stay as well."""
    for english, text in LANGUAGES[code].items():
        for end in (".", "…", " "):
            assert text.endswith(end) == english.endswith(end), english
