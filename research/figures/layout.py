"""Sheets of rendered panels: pictures side by side, each with a title and a line of text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from adaptive_fairing.core import LimitSurface, TriangleTopology
from research.figures.render import Look, View, render

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "figures"

GAP, HEAD = 10, 42
"""Pixels between panels, and above each for its text."""

TITLE_SIZE, TEXT_SIZE = 17, 13
"""Of the letters, in pixels."""

LEVELS = 72
"""Levels of brightness kept in the file: plenty for clay, and a third of the size."""


@dataclass(frozen=True)
class Shot:
    """One rendered view and its size in pixels."""

    view: View
    size: tuple[int, int]


@dataclass(frozen=True)
class Panel:
    """One mesh with a title and a line of explanation."""

    positions: NDArray[np.float64]
    title: str
    text: str


def figure(
    path: Path,
    panels: Sequence[Sequence[Panel]],
    triangles: NDArray[np.int32],
    shots: Sequence[Sequence[Shot]],
    samples: int = 12,
    levels: int | None = None,
) -> None:
    """Render all panels and write them as one PNG; the rest is as in `sheet`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    _with_levels(sheet(panels, triangles, shots, samples, levels)).save(path, optimize=True)


def sheet(
    panels: Sequence[Sequence[Panel]],
    triangles: NDArray[np.int32],
    shots: Sequence[Sequence[Shot]],
    samples: int = 12,
    levels: int | None = None,
) -> Image.Image:
    """Render all panels into one picture.

    Parameters
    ----------
    panels
        Rows of panels.
    triangles
        (m, 3) vertex indices, the same for all panels.
    shots
        The views of every panel: columns, from left to right, of views from top to bottom.
    samples
        Cycles samples per pixel.
    levels
        Draw the limit surfaces smoothly, with each triangle cut into 4 ** levels; by default the
        meshes themselves, flat.
    """
    width = sum(max(shot.size[0] for shot in column) for column in shots)
    height = max(sum(shot.size[1] for shot in column) for column in shots)
    across, down = width + GAP, HEAD + height + GAP
    size = (max(map(len, panels)) * across + GAP, len(panels) * down + GAP)
    picture = Image.new("RGB", size, "white")
    draw = ImageDraw.Draw(picture)
    for i, row in enumerate(panels):
        for k, panel in enumerate(row):
            left, top = GAP + k * across, i * down + HEAD
            draw.text((left, top - 22), panel.title, "black", font(TITLE_SIZE), anchor="ls")
            draw.text((left, top - 7), panel.text, "#444444", font(TEXT_SIZE), anchor="ls")
            _render_into(picture, (left, top), panel, triangles, shots, samples, levels)
            draw.rectangle((left, top, left + width - 1, top + height - 1), outline="#c8c8c8")
    return picture


def font(size: int) -> ImageFont.FreeTypeFont:
    """Return a font whose letters are so many pixels high."""
    return ImageFont.truetype(matplotlib.get_data_path() + "/fonts/ttf/DejaVuSans.ttf", size)


def _render_into(picture, place, panel, triangles, shots, samples, levels) -> None:
    """Render the shots of a panel."""
    positions, is_smooth = panel.positions, levels is not None
    if is_smooth:
        topology = TriangleTopology(triangles, len(positions))
        positions, triangles, _ = LimitSurface(topology, positions).refined(levels)
    left = place[0]
    for column in shots:
        top = place[1]
        for shot in column:
            look = Look(size=shot.size, samples=samples, smooth=is_smooth)
            item = render(positions, triangles, shot.view, look)
            picture.paste(item, (left, top), item)
            top += shot.size[1]
        left += max(shot.size[0] for shot in column)


def _with_levels(sheet: Image.Image) -> Image.Image:
    """Return the picture with one colour for each level of brightness, its mean colour there.

    Pillow's own choice of colours follows how often they occur, and leaves dark parts spotted.
    """
    level = np.asarray(sheet.convert("L")).astype(int) * (LEVELS - 1) // 255
    colors = np.asarray(sheet).reshape(-1, 3)
    count = np.maximum(np.bincount(level.ravel(), minlength=LEVELS), 1)
    sums = [np.bincount(level.ravel(), channel, minlength=LEVELS) for channel in colors.T]
    palette = np.round(np.stack(sums, axis=1) / count[:, None]).astype(np.uint8)
    reduced = Image.fromarray(level.astype(np.uint8), mode="P")
    reduced.putpalette(palette.tobytes())
    return reduced
