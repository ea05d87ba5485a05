"""Settings of `denoise`: what they accept; tests/core/test_errors.py has what they refuse."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from adaptive_fairing.core import DenoiseSettings
from adaptive_fairing.core.denoising.settings import CLEAN, FEATURES, LARGEST_STRENGTH, WIDTHS


@pytest.mark.parametrize(
    "given",
    [
        *({"features": each} for each in FEATURES),
        *({"clean": each} for each in CLEAN),
        *({"width": each} for each in (*WIDTHS, 2.5, "auto")),
        *({"strength": each} for each in (1e-6, np.nextafter(LARGEST_STRENGTH, 0))),
        {"max_deviation": 1e-9},
        {"max_deviation": None},
    ],
)
def test_the_ends_of_every_range_are_allowed(given):
    ((name, value),) = given.items()
    assert getattr(DenoiseSettings(**given), name) == value


@pytest.mark.parametrize("width", [2, np.int64(2), np.float32(2)])
def test_a_width_becomes_pythons_own_number(width):
    settings = DenoiseSettings(width=width)
    assert type(settings.width) is float
    assert settings == DenoiseSettings(width=2.0)


def test_they_cannot_be_changed():
    with pytest.raises(FrozenInstanceError):
        DenoiseSettings().strength = 2.0
