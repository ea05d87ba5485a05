"""Shared set-up of the tests of the core."""

import pytest


@pytest.fixture
def made_spaces(monkeypatch):
    """Give a list to which every preparation of a mesh adds the finite element space it makes."""
    from adaptive_fairing.core.problem import prepared_surface

    made = []

    class Noted(prepared_surface.LoopSpace):
        def __init__(self, *given):
            super().__init__(*given)
            made.append(self)

    monkeypatch.setattr(prepared_surface, "LoopSpace", Noted)
    return made
