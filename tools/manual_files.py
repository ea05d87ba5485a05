"""A hook of mkdocs: pages in docs/ may link to files elsewhere in the repository.

So the same link works on a page of the repository and on the site: what is linked is added to the
site, at its place in the repository, and the link is rewritten. Pages in docs/ are at the root of
the site.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
PAGES = "docs"
LINK = re.compile(r"(?<=\]\()(?![a-z]+:|#)([^)#\s]+)")


def on_files(files: Files, *, config: Any) -> Files:
    """Add what pages link to outside docs/, and what those pages link to in turn."""
    waiting = [f"{PAGES}/{file.src_uri}" for file in files.documentation_pages()]
    seen = set(waiting)
    while waiting:
        page = waiting.pop()
        for link in LINK.findall((ROOT / page).read_text("utf-8")):
            target = _in_repository(page, link)
            if target in seen or not (ROOT / target).is_file():
                continue
            seen.add(target)
            if target.endswith(".md"):
                waiting.append(target)
            if not target.startswith(f"{PAGES}/"):
                files.append(
                    File.generated(config, _on_site(target), abs_src_path=str(ROOT / target))
                )
    return files


def on_page_markdown(markdown: str, *, page: Any, files: Files, config: Any) -> str:
    """Rewrite the links of a page from places in the repository to places on the site."""
    source = page.file.src_uri
    at = f"{PAGES}/{source}" if (ROOT / PAGES / source).is_file() else source
    here = posixpath.dirname(source)

    def on_site(link: re.Match[str]) -> str:
        target = _in_repository(at, link[1])
        if not (ROOT / target).exists():
            return link[1]  # mkdocs says so
        return posixpath.relpath(_on_site(target), here or ".")

    return LINK.sub(on_site, markdown)


def _in_repository(page: str, link: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(page), link))


def _on_site(path: str) -> str:
    """Place on the site of a file of the repository."""
    if path == "README.md":
        return "install.md"  # docs/index.md is the front page
    return path.removeprefix(f"{PAGES}/")
