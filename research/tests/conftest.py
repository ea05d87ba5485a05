"""Test set-up of the research: that of the product's tests."""

from tests.conftest import pytest_sessionfinish  # noqa: F401  ends the process as they do
