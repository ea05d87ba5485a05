"""Pictures for README and for extensions.blender.org: `python -m research.figures.listing`.

Every picture shows a noisy sample mesh and what `denoise` makes of it with its default settings.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from adaptive_fairing.blender.data.color_map import (
    DIVERGING_ANCHORS,
    colors_srgb,
    srgb_to_linear,
    symmetric_range,
)
from adaptive_fairing.core import DenoiseResult, denoise
from research.claims.pairs import MeshPair, sample_pair
from research.figures.render import Look, View, render
from tools.geometry.triangles import vertex_normals

from .layout import font

ROOT = Path(__file__).resolve().parents[2]
LISTING = ROOT / "assets" / "listing"
README = ROOT / "assets" / "figures" / "denoise.png"
FULL = (1920, 1080)
HALF = (960, 1080)

BACKDROP = (38, 40, 44)
PAPER = (255, 255, 255)
INK = (236, 236, 236)
TEXT_SIZE, NAME_SIZE = 40, 84

HEAD = View((0.75, -1.0, 0.15), box=((-7.0, -12.0, -1.0), (8.0, 10.0, 23.0)), margin=0.0)
FACE = View((0.75, -1.0, 0.1), box=((-5.0, -11.0, 2.0), (8.5, 4.0, 15.0)))
FOOT = View((0.9, -1.0, 0.7), box=((-5.0, -12.4, -0.5), (5.1, 13.7, 17.6)))
TOES = View((0.45, -1.0, 0.9), box=((-4.6, -12.2, 0.0), (4.6, -5.4, 3.0)))
CROCODILE = View((0.35, -1.0, 0.7), box=((0.0, -6.0, 4.0), (26.0, 3.0, 10.0)))
EYE = View((-0.35, -1.0, 0.5), box=((-31.0, -7.0, 3.0), (-21.0, -1.0, 8.0)))
SNOUT = View((-0.35, -1.0, 0.5), box=((-42.0, -9.5, 3.0), (-17.0, -1.0, 8.5)))


@dataclass(frozen=True)
class Scene:
    """A sample mesh and where it is seen from: a box, so that both pictures have one frame."""

    name: str
    view: View

    @property
    def pair(self) -> MeshPair:
        """The noisy mesh and the clean one."""
        return sample_pair(self.name)

    def picture(self, size: tuple[int, int], *, is_noisy: bool) -> Image.Image:
        """Return the mesh before or after, on nothing."""
        positions = self.pair.noisy if is_noisy else denoised(self.name).positions
        return render(positions, self.pair.triangles, self.view, look(size))


def main() -> None:
    """Render all of them."""
    LISTING.mkdir(parents=True, exist_ok=True)
    _for_readme().save(README, optimize=True)
    _icon().save(LISTING / "icon.png", optimize=True)
    _removed(Scene("head", HEAD)).save(LISTING / "preview_4.png", optimize=True)
    _featured().save(LISTING / "featured.png", optimize=True)
    previews = {
        1: Scene("head", FACE),
        2: Scene("foot", FOOT),
        3: Scene("crocodile", SNOUT),
        5: Scene("crocodile", CROCODILE),
    }
    for number, scene in previews.items():
        _side_by_side(scene).save(LISTING / f"preview_{number}.png", optimize=True)


def look(size: tuple[int, int]) -> Look:
    """Few samples are enough in even light, because the renderer removes its own noise."""
    return Look(size=size, samples=5)


@cache
def denoised(name: str) -> DenoiseResult:
    """Denoise a sample with the default settings."""
    pair = sample_pair(name)
    return denoise(pair.noisy, pair.triangles)


def _side_by_side(scene: Scene) -> Image.Image:
    sheet = Image.new("RGB", FULL, BACKDROP)
    for index, title in enumerate(("Before", "After Denoise")):
        item = scene.picture(HALF, is_noisy=index == 0)
        sheet.paste(item, (index * HALF[0], 0), item)
        _write(sheet, (index * HALF[0] + 40, 34), title, TEXT_SIZE)
    return sheet


def _removed(scene: Scene) -> Image.Image:
    """Return before, after, and what was removed as colours."""
    size = (FULL[0] // 3, FULL[1])
    sheet = Image.new("RGB", FULL, BACKDROP)
    pair, result = scene.pair, denoised(scene.name)
    normals = vertex_normals(result.positions, pair.triangles)
    moved = np.einsum("nd,nd->n", pair.noisy - result.positions, normals)
    colors = srgb_to_linear(colors_srgb(moved, *symmetric_range(moved), DIVERGING_ANCHORS))
    items = [
        ("Before", scene.picture(size, is_noisy=True)),
        ("After Denoise", scene.picture(size, is_noisy=False)),
        (
            "What was removed",
            render(result.positions, pair.triangles, scene.view, look(size), colors),
        ),
    ]
    for index, (title, item) in enumerate(items):
        sheet.paste(item, (index * size[0], 0), item)
        _write(sheet, (index * size[0] + 30, 34), title, TEXT_SIZE)
    return sheet


def _icon() -> Image.Image:
    """Return a head of which the left half is noisy, on a round corner plate."""
    side = 256
    plate = Image.new("RGBA", (side, side), (0, 0, 0, 0))
    ImageDraw.Draw(plate).rounded_rectangle(
        (0, 0, side - 1, side - 1), radius=48, fill=(62, 96, 132)
    )
    plate.alpha_composite(_halves(Scene("head", HEAD), (side, side)))
    return plate


def _featured() -> Image.Image:
    sheet = Image.new("RGB", FULL, BACKDROP)
    item = _halves(Scene("head", HEAD), (1000, FULL[1]))
    sheet.paste(item, (FULL[0] - 1000, 0), item)
    _write(sheet, (100, 400), "Adaptive Fairing", NAME_SIZE)
    _write(sheet, (104, 520), "Removes noise from meshes.", TEXT_SIZE)
    _write(sheet, (104, 576), "Keeps their details.", TEXT_SIZE)
    return sheet


def _for_readme() -> Image.Image:
    """Return head, foot and crocodile, before above after."""
    scenes = (Scene("head", FACE), Scene("foot", TOES), Scene("crocodile", EYE))
    size = (400, 400)
    sheet = Image.new("RGB", (len(scenes) * size[0], 2 * size[1]), PAPER)
    for column, scene in enumerate(scenes):
        for row in range(2):
            item = scene.picture(size, is_noisy=row == 0)
            sheet.paste(item, (column * size[0], row * size[1]), item)
    return sheet.quantize(128)


def _halves(scene: Scene, size: tuple[int, int]) -> Image.Image:
    """Return the noisy left half and the denoised right half of one picture."""
    sheet = scene.picture(size, is_noisy=False)
    left = (0, 0, size[0] // 2, size[1])
    sheet.paste(scene.picture(size, is_noisy=True).crop(left), left[:2])
    return sheet


def _write(sheet: Image.Image, place: tuple[int, int], text: str, size: int) -> None:
    """Write on a plate, because a mesh may lie behind the text."""
    draw = ImageDraw.Draw(sheet)
    left, top, right, bottom = draw.textbbox(place, text, font(size))
    draw.rounded_rectangle((left - 16, top - 14, right + 16, bottom + 14), 12, fill=BACKDROP)
    draw.text(place, text, INK, font(size))


if __name__ == "__main__":
    main()
