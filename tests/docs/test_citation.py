"""CITATION.cff and README name the same paper, and claim no venue."""

import re

from support.pages import ROOT

TITLE = "Adaptive Fairing of Surface Meshes by Geometric Diffusion"


def test_the_paper_is_cited_alike():
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    readme = (ROOT / "README.md").read_text("utf-8")
    (entry,) = re.findall(r"^```bibtex\n(.*?)^```$", readme, re.M | re.S)
    for text in (citation, entry):
        assert TITLE in text
        assert "Bajaj" in text and "Xu" in text and "Chandrajit L." in text and "Guoliang" in text
    assert not re.search(r"booktitle|journal|year|doi", entry)
    assert not re.search(r"conference|journal|year|doi", citation.split("references:")[1])
