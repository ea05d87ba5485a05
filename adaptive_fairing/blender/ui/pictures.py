"""Small pictures for the panel, drawn with numpy: the course of H, and the colour scale."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from bpy.utils import previews
from numpy.typing import NDArray

from ..data.color_map import ANCHORS, DIVERGING_ANCHORS, colors_srgb

Image = NDArray[np.float64]

PLOT_SIZE = 192
LINE_COLOR = (0.98, 0.62, 0.22)
GRID_COLOR = (0.5, 0.5, 0.5)
SCALE_SIZE = 160
SCALE_BAR = slice(96, 140)
SCALE_TICKS = 5
TICK_LENGTH = 12
REMEMBERED = 16

_collections: list[previews.ImagePreviewCollection] = []


def plot_icon(values: Sequence[float]) -> int:
    """Icon of a plot of values over their index, the vertical axis starting at 0."""
    shown = tuple(float(f"{value:.4g}") for value in values)
    return _icon(f"plot {shown}", lambda: draw_plot(shown))


def scale_icon(*, is_signed: bool = False) -> int:
    """Icon of the colour scale, low at the bottom; of a signed field with 0 in the middle."""
    if is_signed:
        return _icon("signed scale", lambda: draw_scale(DIVERGING_ANCHORS))
    return _icon("scale", draw_scale)


def draw_plot(values: Sequence[float]) -> Image:
    """Draw a line with a dot per value, and the area below it.

    Parameters
    ----------
    values
        At least one number, none of them negative.

    Returns
    -------
    (PLOT_SIZE, PLOT_SIZE, 4) array
        RGBA, premultiplied as Blender's previews want it; the first row is at the bottom.
    """
    heights = np.nan_to_num(np.asarray(values, dtype=np.float64))
    margin, thickness, dot = 10.0, 1.8, 4.5
    span = PLOT_SIZE - 2 * margin
    x = margin + span * np.linspace(0.0, 1.0, max(len(heights), 2))[: len(heights)]
    y = margin + span * heights / (heights.max() or 1.0)
    columns = np.arange(PLOT_SIZE) + 0.5
    column, row = np.meshgrid(columns, columns)

    image = np.zeros((PLOT_SIZE, PLOT_SIZE, 4))
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        _blend(image, np.abs(row - margin - share * span) < 0.6, GRID_COLOR, 0.35)
    line = np.interp(columns, x, y)
    inside = (column >= x[0]) & (column <= x[-1]) & (row >= margin)
    _blend(image, np.clip(line - row, 0.0, 1.0) * inside, LINE_COLOR, 0.22)
    distance = np.full_like(column, np.inf)
    for start, end in zip(np.stack([x, y], 1)[:-1], np.stack([x, y], 1)[1:], strict=True):
        distance = np.minimum(distance, _distance_to_segment(column, row, start, end))
    _blend(image, np.clip(thickness + 0.5 - distance, 0.0, 1.0), LINE_COLOR, 1.0)
    if span / max(len(heights) - 1, 1) > 3 * dot:
        for point in zip(x, y, strict=True):
            radius = np.hypot(column - point[0], row - point[1])
            _blend(image, np.clip(dot + 0.5 - radius, 0.0, 1.0), LINE_COLOR, 1.0)
    return image


def draw_scale(anchors: Image = ANCHORS) -> Image:
    """Draw a colour map as an upright bar with ticks at its right, RGBA as `draw_plot`."""
    image = np.zeros((SCALE_SIZE, SCALE_SIZE, 4))
    colors = colors_srgb(np.linspace(0.0, 1.0, SCALE_SIZE), anchors=anchors)
    image[:, SCALE_BAR, :3] = colors[:, None, :]
    image[:, SCALE_BAR, 3] = 1.0
    ticks = np.zeros((SCALE_SIZE, SCALE_SIZE))
    for at in np.linspace(0, SCALE_SIZE - 2, SCALE_TICKS).astype(int):
        ticks[at : at + 2, SCALE_BAR.stop : SCALE_BAR.stop + TICK_LENGTH] = 1.0
    _blend(image, ticks, GRID_COLOR, 1.0)
    return image


def _icon(name: str, draw: Callable[[], Image]) -> int:
    """Find the icon of a picture, drawing it if it is not known."""
    collection = _collections[0]
    if name not in collection:
        if len(collection) >= REMEMBERED:
            collection.clear()
        image = draw()
        preview = collection.new(name)
        preview.image_size = image.shape[1::-1]
        preview.image_pixels_float.foreach_set(image.astype(np.float32).ravel())
    return collection[name].icon_id


def _blend(image: Image, coverage: Image, color: Sequence[float], opacity: float) -> None:
    """Lay a colour over the image where it covers a pixel ("over" of premultiplied alpha)."""
    alpha = np.asarray(coverage, dtype=np.float64)[:, :, None] * opacity
    image *= 1.0 - alpha
    image += alpha * np.array([*color, 1.0])


def _distance_to_segment(column: Image, row: Image, start: Image, end: Image) -> Image:
    direction = end - start
    length = max(float(direction @ direction), 1e-12)
    along = (column - start[0]) * direction[0] + (row - start[1]) * direction[1]
    along = np.clip(along / length, 0.0, 1.0)
    return np.hypot(column - start[0] - along * direction[0], row - start[1] - along * direction[1])


def register() -> None:
    """Make room for the pictures."""
    _collections.append(previews.new())


def unregister() -> None:
    """Free the pictures."""
    while _collections:
        previews.remove(_collections.pop())
