"""scipy missing or too old: found out without importing it, said in one line."""

import sys

import pytest

from adaptive_fairing.blender import requirements


@pytest.fixture(autouse=True)
def _fresh():
    requirements.scipy_problem.cache_clear()
    yield
    requirements.scipy_problem.cache_clear()


def test_the_scipy_of_the_tests_will_do():
    assert requirements.scipy_problem() is None


def test_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy", None)
    message = requirements.scipy_problem()
    assert message.startswith("scipy is missing: install")
    assert "\n" not in message


@pytest.mark.parametrize("version", ["1.14.1", "1.9", "0.19.0rc1"])
def test_too_old(monkeypatch, version):
    monkeypatch.setattr(requirements.metadata, "version", lambda name: version)
    message = requirements.scipy_problem()
    assert message.startswith(f"scipy {version} is too old, 1.15 is needed")
    assert "\n" not in message


@pytest.mark.parametrize("version", ["1.15.0", "1.15.3", "1.100.0", "2.0", "1.15.0rc1"])
def test_new_enough(monkeypatch, version):
    monkeypatch.setattr(requirements.metadata, "version", lambda name: version)
    assert requirements.scipy_problem() is None


def test_without_metadata_it_is_trusted(monkeypatch):
    def unknown(name):
        raise requirements.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(requirements.metadata, "version", unknown)
    assert requirements.scipy_problem() is None
