"""The examples in the docstrings of public classes and functions run, and show what they say."""

import doctest
import importlib

import pytest

import adaptive_fairing.core

PUBLIC = [
    "denoise",
    "fair",
    "fair_values",
    "LimitSurface",
    "LoopSpace",
    "TriangleTopology",
    "mesh_density",
]


@pytest.mark.parametrize("name", PUBLIC)
def test_examples(name):
    documented = getattr(adaptive_fairing.core, name)
    module = importlib.import_module(documented.__module__)
    tests = [
        test
        for test in doctest.DocTestFinder().find(documented, name, globs=vars(module).copy())
        if test.examples
    ]
    assert tests, f"{name} has no example"
    for test in tests:
        assert len(test.examples) <= 10
        assert doctest.DocTestRunner().run(test).failed == 0
