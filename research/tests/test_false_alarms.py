"""The rates of wrong decisions come with the intervals that they should."""

from __future__ import annotations

import pytest
from scipy.stats import binom

from research.denoising.false_alarms import interval


def test_the_ends_of_an_interval_make_what_was_found_unlikely():
    low, high = interval(7, 50)
    assert binom.sf(6, 50, low) == pytest.approx(0.025)
    assert binom.cdf(7, 50, high) == pytest.approx(0.025)


@pytest.mark.parametrize("found, end", [(0, 0), (50, 1)])
def test_an_interval_reaches_the_end_where_nothing_or_all_was_found(found, end):
    assert end in interval(found, 50)
