"""Research stays apart: nothing of the product, its tests or its tools imports it."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PRODUCT = ("adaptive_fairing", "benchmarks", "examples", "tests", "tools")


def test_nothing_outside_imports_research():
    sources = [path for folder in PRODUCT for path in (ROOT / folder).rglob("*.py")]
    assert len(sources) > 200
    importing = []
    for path in sources:
        text = path.read_text("utf-8")
        for node in ast.walk(ast.parse(text)) if "research" in text else []:
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            if any(name.split(".")[0] == "research" for name in names):
                importing.append(path.relative_to(ROOT))
    assert not importing
