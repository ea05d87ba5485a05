"""Refinements that cannot fit into memory are refused before they start."""

import pytest

from adaptive_fairing.core.fem.memory_estimate import MemoryNeededError
from adaptive_fairing.core.surface import memory_estimate
from adaptive_fairing.core.surface.memory_estimate import require_memory


@pytest.fixture
def available(monkeypatch):
    """Return a function that sets the memory of the system."""
    return lambda size: monkeypatch.setattr(memory_estimate, "available_bytes", lambda: size)


def test_each_level_and_each_array_needs_more(available):
    needed = []
    for levels, n_arrays in ((1, 0), (2, 0), (2, 10)):
        available(0)
        with pytest.raises(MemoryNeededError) as caught:
            require_memory(100_000, levels, n_arrays)
        needed.append(caught.value.needed)
        available(needed[-1])
        require_memory(100_000, levels, n_arrays)
    bare = needed[1] - needed[0]
    assert bare == memory_estimate.BYTES_PER_TRIANGLE * 100_000 * (16 - 4)
    assert needed[2] - needed[1] == 10 * memory_estimate.BYTES_PER_VALUE * 1_600_000


def test_the_message_has_the_numbers(available):
    available(10**9)
    message = (
        r"6400000 refined triangles need about 2\.6 GB of memory, 1\.0 GB are available: "
        "choose fewer levels"
    )
    with pytest.raises(MemoryNeededError, match=message):
        require_memory(100_000, 3, 0)


def test_nothing_is_refused_where_the_memory_is_not_known(available):
    available(None)
    require_memory(10**9, 3, 100)
