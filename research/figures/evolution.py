"""Film of the head while it is faired: the surface in grey, and the density in colours.

Run `python -m research.figures.evolution [-o FILE.gif]`. It films a .blend like that of the
README's first command, with the script that `examples/` has for it.
"""

from __future__ import annotations

import argparse
import runpy
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from PIL import Image, ImageDraw

from adaptive_fairing.blender.data.color_map import colors_srgb
from adaptive_fairing.blender.jobs.file_job import FRAMES_PER_STEP, FairingJob, run_job
from adaptive_fairing.core import FairingSettings
from research.figures.layout import FOLDER, font

ROOT = Path(__file__).resolve().parents[2]
SETTINGS = FairingSettings(density="area", radius=0.7)
WIDTH, SAMPLES, EVERY = 600, 8, 2
CAPTION = 46
"""Pixels above the picture for the text."""

FIRST, EACH, LAST = 1200, 120, 2400
"""Milliseconds for which the first picture, each one between and the last are shown."""

COLORS = 255
"""Colours kept in the file, the same for all pictures: nothing flickers."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Film the head."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "-o", "--output", type=Path, default=FOLDER / "evolution.gif", metavar="FILE.gif"
    )
    options = parser.parse_args(arguments)
    script = runpy.run_path(str(ROOT / "examples" / "render_evolution.py"))
    with tempfile.TemporaryDirectory() as folder:
        blend = Path(folder, "head.blend")
        run_job(FairingJob(ROOT / "assets" / "head_noisy.ply", blend, SETTINGS))
        bpy.ops.wm.open_mainfile(filepath=str(blend))
        numbers = {"width": WIDTH, "samples": SAMPLES, "every": EVERY}
        script["main"]([folder, *(word for k, v in numbers.items() for word in (f"--{k}", str(v)))])
        pictures = [Image.open(path).convert("RGB") for path in sorted(Path(folder).glob("*.png"))]
    frames = [
        _captioned(picture, min(EVERY * place / FRAMES_PER_STEP, SETTINGS.steps))
        for place, picture in enumerate(pictures)
    ]
    _write_gif(options.output, frames)
    return 0


def _captioned(picture: Image.Image, time: float) -> Image.Image:
    """Write above a picture how far the evolution is, 1 after the first step, and a legend."""
    sheet = Image.new("RGB", (picture.width, picture.height + CAPTION), "white")
    sheet.paste(picture, (0, CAPTION))
    draw = ImageDraw.Draw(sheet)
    step = "input" if time == 0 else f"step {int(np.ceil(time))}"
    draw.text((10, 20), "Adaptive Fairing", "black", font(16), anchor="ls")
    draw.text((10, 38), step, "#444444", font(14), anchor="ls")
    left = picture.width // 2
    draw.text((left, 20), "Density: small triangles to large ones", "black", font(14), anchor="ls")
    bar = np.round(255 * colors_srgb(np.arange(200))).astype(np.uint8)
    sheet.paste(Image.fromarray(np.repeat(bar[None], 9, axis=0)), (left, 28))
    return sheet


def _write_gif(path: Path, frames: Sequence[Image.Image]) -> None:
    whole = Image.new("RGB", (frames[0].width, frames[0].height * 2))
    whole.paste(frames[0], (0, 0))
    whole.paste(frames[-1], (0, frames[0].height))
    palette = whole.quantize(COLORS, kmeans=2, dither=Image.Dither.NONE)
    reduced = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    times = [FIRST, *[EACH] * (len(frames) - 2), LAST]
    reduced[0].save(
        path, save_all=True, append_images=reduced[1:], duration=times, loop=0, optimize=True
    )


if __name__ == "__main__":
    sys.exit(main())
