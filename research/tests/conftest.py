"""Test set-up of the research: that of the product's tests, and a ball."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import (  # noqa: F401  hooks of pytest
    pytest_sessionfinish,
    pytest_xdist_auto_num_workers,
)
from tests.support.meshes import graded_sphere


@pytest.fixture(scope="session")
def ball() -> tuple[np.ndarray, np.ndarray]:
    """Make a sphere of uneven density."""
    return graded_sphere(4)
