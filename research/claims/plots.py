"""Style of all plots of the claims."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

PANEL_SIZE = (4.6, 3.6)
RESOLUTION = 100
COLORS = 48
"""Kept in the file: lines on white need no more."""


def figure(n_panels: int):
    """Return a figure with panels side by side, and their axes."""
    width, height = PANEL_SIZE
    drawing, axes = pyplot.subplots(1, n_panels, figsize=(n_panels * width, height), squeeze=False)
    for axis in axes[0]:
        axis.grid(True, which="major", color="0.88")
        axis.set_axisbelow(True)
        axis.title.set_fontsize(10)
    return drawing, axes[0]


def save(drawing, path: Path) -> None:
    """Write the figure as a small PNG and forget it."""
    from PIL import Image

    drawing.tight_layout()
    drawing.savefig(path, dpi=RESOLUTION)
    pyplot.close(drawing)
    with Image.open(path) as picture:
        reduced = picture.convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
    reduced.save(path, optimize=True)
