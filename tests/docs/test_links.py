"""Links between the files of the repository lead somewhere, as do anchors and named programs."""

from __future__ import annotations

import re

import pytest
from support.pages import PAGES, ROOT, anchors

PROGRAM = re.compile(
    r"python (?:-m ((?:adaptive_fairing|benchmarks|research)[\w.]*)|(\w+/[\w/]+\.py))"
)
LINK = re.compile(r"\]\((?![a-z]+:)([^)#\s]*)(?:#([^)\s]+))?\)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    for target, anchor in LINK.findall(page.read_text("utf-8")):
        found = (page.parent / target).resolve() if target else page
        assert found.exists(), f"{target} is missing"
        if anchor:
            assert anchor in anchors(found), f"{target}#{anchor} is missing"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_programs_that_a_page_names_exist(page):
    for module, script in PROGRAM.findall(page.read_text("utf-8")):
        place = ROOT / (script or module.rstrip(".").replace(".", "/"))
        assert any(
            each.is_file() for each in (place, place.with_suffix(".py"), place / "__main__.py")
        ), f"there is no {module or script}"


def test_every_page_is_in_the_manuals_list():
    index = (ROOT / "docs" / "index.md").read_text("utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        assert page.name == "index.md" or f"]({page.name})" in index
