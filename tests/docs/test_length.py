"""The manual stays short enough to be read in an evening."""

from __future__ import annotations

from support.pages import ROOT

MOST_WORDS = 17_000


def test_the_pages_have_few_words():
    n_words = sum(len(page.read_text("utf-8").split()) for page in (ROOT / "docs").glob("*.md"))
    assert n_words <= MOST_WORDS
