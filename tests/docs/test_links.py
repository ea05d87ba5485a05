"""Links between the files of the repository lead somewhere, and so do their anchors."""

from __future__ import annotations

import re

import pytest
from support.pages import PAGES, ROOT, anchors

LINK = re.compile(r"\]\((?![a-z]+:)([^)#\s]*)(?:#([^)\s]+))?\)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    for target, anchor in LINK.findall(page.read_text("utf-8")):
        found = (page.parent / target).resolve() if target else page
        assert found.exists(), f"{target} is missing"
        if anchor:
            assert anchor in anchors(found), f"{target}#{anchor} is missing"


def test_every_page_is_in_the_manuals_list():
    index = (ROOT / "docs" / "index.md").read_text("utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        assert page.name == "index.md" or f"]({page.name})" in index
