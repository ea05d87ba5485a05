"""Texts of the interface in other languages: one file for each, named by the language's code.

The keys of a file are the English texts of the source. Placeholders are not translated: texts are
translated before they are filled in. Messages of the numeric core are English only.
"""

from __future__ import annotations

import json
from pathlib import Path

import bpy

from ...run_properties import CONTEXT


def languages() -> dict[str, dict[str, str]]:
    """Read the files of this folder: for each language code, translations by English text."""
    files = Path(__file__).parent.glob("*.json")
    return {path.stem: json.loads(path.read_text("utf-8")) for path in sorted(files)}


def register() -> None:
    """Register the translations with Blender, which uses ``de`` for ``de_DE`` as well."""
    # Labels of operators have a context of their own.
    contexts = ("*", bpy.app.translations.contexts.operator_default, CONTEXT)
    offered = {
        code: {(context, key): text for key, text in texts.items() for context in contexts}
        for code, texts in languages().items()
    }
    bpy.app.translations.register(__package__, offered)


def unregister() -> None:
    """Withdraw the translations."""
    bpy.app.translations.unregister(__package__)
