"""Sheets of rendered panels: pictures side by side, each with a title and a line of text."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from adaptive_fairing.core import LimitSurface, TriangleTopology
from render import Look, View, render

matplotlib.use("Agg")
from matplotlib import pyplot

FOLDER = Path(__file__).resolve().parents[2] / "assets" / "figures"

GAP, HEAD = 10, 42
"""Pixels between panels, and above each for its text."""

DPI = 100
TITLE_SIZE, TEXT_SIZE = 12, 9

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
    levels
        Draw the limit surfaces smoothly, with each triangle cut into 4 ** levels; by default the
        meshes themselves, flat.
    """
    width = sum(max(shot.size[0] for shot in column) for column in shots)
    height = max(sum(shot.size[1] for shot in column) for column in shots)
    sheet = np.array([max(map(len, panels)) * (width + GAP), len(panels) * (height + HEAD + GAP)])
    sheet += GAP
    drawing = pyplot.figure(figsize=sheet / DPI, dpi=DPI)
    for i, row in enumerate(panels):
        for k, panel in enumerate(row):
            left, bottom = GAP + k * (width + GAP), sheet[1] - (i + 1) * (height + HEAD + GAP)
            axis = drawing.add_axes([*([left, bottom] / sheet), *([width, height] / sheet)])
            axis.imshow(_rendered(panel, triangles, shots, (height, width), samples, levels))
            axis.set(xticks=[], yticks=[])
            axis.spines[:].set_color("#c8c8c8")
            axis.annotate(
                panel.title, (0, height + 20), xycoords="axes pixels", fontsize=TITLE_SIZE
            )
            axis.annotate(
                panel.text,
                (0, height + 5),
                xycoords="axes pixels",
                fontsize=TEXT_SIZE,
                color="#444",
            )
    path.parent.mkdir(parents=True, exist_ok=True)
    drawing.savefig(path, dpi=DPI)
    pyplot.close(drawing)
    with Image.open(path) as picture:
        reduced = _with_levels(picture.convert("RGB"))
    reduced.save(path, optimize=True)


def _rendered(panel, triangles, shots, size, samples, levels) -> NDArray[np.float64]:
    """Render the shots of a panel over white."""
    image = np.ones((*size, 3))
    left = 0
    positions, is_smooth = panel.positions, levels is not None
    if is_smooth:
        topology = TriangleTopology(triangles, len(positions))
        positions, triangles, _ = LimitSurface(topology, positions).refined(levels)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shot.png"
        for column in shots:
            top = 0
            for shot in column:
                look = Look(size=shot.size, samples=samples, smooth=is_smooth)
                render(path, positions, triangles, shot.view, look)
                color, alpha = np.split(pyplot.imread(path), [3], axis=2)
                across, down = shot.size
                image[top : top + down, left : left + across] = color * alpha + 1 - alpha
                top += down
            left += max(shot.size[0] for shot in column)
    return image


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
