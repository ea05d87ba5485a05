"""Labels of buttons and fields in the manual are those of the add-on."""

from __future__ import annotations

import re

import pytest
from support.pages import ROOT

PAGES = (
    "README.md",
    *(
        f"docs/{name}.md"
        for name in (
            "denoise-in-one-minute",
            "paper-in-five-minutes",
            "clean-a-scan",
            "keep-a-region",
            "hard-surface",
            "sequences",
            "colours",
            "surface",
            "settings",
            "troubleshooting",
        )
    ),
)
SOURCES = "\n".join(
    path.read_text("utf-8") for path in (ROOT / "adaptive_fairing" / "blender").rglob("*.py")
)
KEYS = {"N", "X", "Tab", "Esc", "Space", "Alt B", "Alt N"}


@pytest.mark.parametrize("page", PAGES)
def test_bold_words_are_labels_of_the_panel(page):
    """Bold words that end in a stop, a comma or a colon are emphasis or a heading."""
    text = (ROOT / page).read_text("utf-8")
    for phrase in re.findall(r"\*\*([A-Z][^*]*?[^*.,:?])\*\*(?!:)", text, re.S):
        for label in " ".join(phrase.split()).split(" › "):
            if label not in KEYS:
                assert f'"{label}"' in SOURCES, f"no label {label!r}"
