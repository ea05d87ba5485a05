"""Panels of rendered meshes with captions, put together into one picture with Pillow."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from render import Look, View, render

GAP = 10
TITLE_SIZE, TEXT_SIZE = 17, 13
FONT = matplotlib.get_data_path() + "/fonts/ttf/DejaVuSans.ttf"
"""Pillow's own font has no Greek letters."""

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
) -> None:
    """Render all panels and write them as one PNG.

    Parameters
    ----------
    path
        File to write.
    panels
        Rows of panels.
    triangles
        (m, 3) vertex indices, the same for all panels.
    shots
        The views of every panel: columns, from left to right, of views from top to bottom.
    samples
        Cycles samples per pixel.
    """
    rows = [[_panel(panel, triangles, shots, samples) for panel in row] for row in panels]
    width = max(sum(item.width + GAP for item in row) for row in rows) + GAP
    height = sum(max(item.height for item in row) + GAP for row in rows) + GAP
    sheet = Image.new("RGB", (width, height), "white")
    top = GAP
    for row in rows:
        left = GAP
        for item in row:
            sheet.paste(item, (left, top))
            left += item.width + GAP
        top += max(item.height for item in row) + GAP
    path.parent.mkdir(parents=True, exist_ok=True)
    _with_levels(sheet).save(path, optimize=True)


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


def _panel(panel, triangles, shots, samples):
    columns = []
    for column in shots:
        images = [_shot(panel, triangles, shot, samples) for shot in column]
        joined = Image.new(
            "RGB",
            (max(item.width for item in images), sum(item.height for item in images)),
            "white",
        )
        top = 0
        for item in images:
            joined.paste(item, (0, top))
            top += item.height
        columns.append(joined)
    head = TITLE_SIZE + TEXT_SIZE + 14
    sheet = Image.new(
        "RGB",
        (sum(item.width for item in columns), max(item.height for item in columns) + head),
        "white",
    )
    left = 0
    for item in columns:
        sheet.paste(item, (left, head))
        left += item.width
    draw = ImageDraw.Draw(sheet)
    draw.text((6, 3), panel.title, fill="black", font=ImageFont.truetype(FONT, TITLE_SIZE))
    draw.text(
        (6, 7 + TITLE_SIZE), panel.text, fill="#444444", font=ImageFont.truetype(FONT, TEXT_SIZE)
    )
    draw.rectangle((0, 0, sheet.width - 1, sheet.height - 1), outline="#c8c8c8")
    return sheet


def _shot(panel, triangles, shot, samples):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shot.png"
        look = Look(size=shot.size, samples=samples)
        render(path, panel.positions, triangles, shot.view, look)
        image = Image.open(path).convert("RGBA")
    background = Image.new("RGBA", image.size, "white")
    background.alpha_composite(image)
    return background.convert("RGB")
