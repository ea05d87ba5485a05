"""Object of the tests of what a mesh stores."""

import pytest


@pytest.fixture
def obj():
    """Add a ball of 42 vertices."""
    from support.meshes import icosphere
    from support.objects import add_object

    return add_object(*icosphere(1))
