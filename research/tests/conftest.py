"""Test set-up of the research: that of the product's tests."""

from tests.conftest import (  # noqa: F401  hooks of pytest
    pytest_sessionfinish,
    pytest_xdist_auto_num_workers,
)
