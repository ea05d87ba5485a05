"""A hook of mkdocs: formulas become MathML, which browsers show without a script or a network."""

from __future__ import annotations

import html
import re
from typing import Any

from latex2mathml.converter import convert

# What the extension arithmatex makes of $…$ and $$…$$, in its generic form.
FORMULA = re.compile(r'<(?:span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</(?:span|div)>', re.S)
TAG = re.compile(r"\\tag\{(.*?)\}")


def on_page_content(content: str, **_: Any) -> str:
    """Replace the formulas of a page."""
    return FORMULA.sub(_mathml, content)


def _mathml(formula: re.Match[str]) -> str:
    latex = TAG.sub(r"\\qquad\\text{(\1)}", html.unescape(formula[2]).strip())
    return str(convert(latex, display="block" if formula[1] == "[" else "inline"))
