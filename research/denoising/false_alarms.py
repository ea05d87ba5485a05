"""Rates at which `denoise` changes a clean model, and misses noise.

    python -m research.denoising.false_alarms              200 random models
    python -m research.denoising.false_alarms --models 50 --seed 1

First every mesh primitive of Blender, at its default and at fine settings, is denoised as it is.
Then random models, each a primitive of random proportions under one to three random modifiers, are
denoised as they are and, if they have 400 vertices or more, with normal noise of 0.2.  Prints
tables in Markdown, with confidence intervals of 95 % after Clopper and Pearson.  Nothing was tuned
on these models.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence

import bpy
import numpy as np
from scipy.stats import beta
from tqdm import tqdm

from adaptive_fairing.core import denoise
from benchmarks.measuring import table
from tools.geometry.blender_meshes import add_modifier, evaluated
from tools.geometry.triangles import Faces, FloatArray

from .noise import add_noise

Mesh = tuple[FloatArray, Faces]

NOISE, FEWEST, MOST = 0.2, 400, 40_000

PRIMITIVES: dict[str, tuple[Callable[..., object], dict]] = {
    "cube": (bpy.ops.mesh.primitive_cube_add, {}),
    "plane": (bpy.ops.mesh.primitive_plane_add, {}),
    "grid": (bpy.ops.mesh.primitive_grid_add, {"x_subdivisions": 100, "y_subdivisions": 100}),
    "UV sphere": (bpy.ops.mesh.primitive_uv_sphere_add, {"segments": 128, "ring_count": 64}),
    "ico sphere": (bpy.ops.mesh.primitive_ico_sphere_add, {"subdivisions": 6}),
    "cylinder": (bpy.ops.mesh.primitive_cylinder_add, {"vertices": 512}),
    "cone": (bpy.ops.mesh.primitive_cone_add, {"vertices": 512}),
    "torus": (bpy.ops.mesh.primitive_torus_add, {"major_segments": 192, "minor_segments": 64}),
    "Suzanne": (bpy.ops.mesh.primitive_monkey_add, {}),
}
"""Operator that adds each primitive, and its fine settings."""

MODIFIERS: dict[str, Callable[[np.random.Generator], dict]] = {
    "BEVEL": lambda random: {
        "width": random.uniform(0.03, 0.15), "segments": int(random.integers(1, 5)),
    },
    "SUBSURF": lambda random: {"levels": int(random.integers(1, 4))},
    "DECIMATE": lambda random: {"ratio": random.uniform(0.15, 0.8)},
    "REMESH": lambda random: {"mode": "VOXEL", "voxel_size": random.uniform(0.05, 0.2)},
    "SOLIDIFY": lambda random: {"thickness": random.uniform(0.05, 0.2)},
    "ARRAY": lambda random: {"count": int(random.integers(2, 5))},
    "SIMPLE_DEFORM": lambda random: {
        "deform_method": str(random.choice(["TWIST", "BEND", "TAPER"])),
        "factor": random.uniform(0.2, 0.8), "angle": random.uniform(0.2, 0.8),
    },
}  # fmt: skip
"""Modifiers that modellers use, with random settings."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", type=int, default=200, help="how many (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the first (default %(default)s)")
    options = parser.parse_args(arguments)
    print(table(("primitive", "vertices", "moved"), [*_of_primitives()]))
    changed, missed, n_noisy = [], [], 0
    for number in tqdm(range(options.seed, options.seed + options.models), unit="model"):
        name, (vertices, faces) = random_model(np.random.default_rng(number))
        if _is_changed(vertices, faces):
            changed.append(f"{number} ({name})")
        if len(vertices) >= FEWEST:
            n_noisy += 1
            if not _is_changed(add_noise(vertices, faces, "normal", NOISE, number), faces):
                missed.append(f"{number} ({name})")
    rows = [
        rate_row("clean models that were changed", changed, options.models),
        rate_row("noisy ones that were not", missed, n_noisy),
    ]
    print(f"\n{table(('', 'models', '95 % interval of the rate', 'which'), rows)}")


def interval(n_found: int, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Confidence interval of a rate, after Clopper and Pearson."""
    tail = (1 - confidence) / 2
    low = beta.ppf(tail, n_found, n - n_found + 1) if n_found else 0.0
    high = beta.ppf(1 - tail, n_found + 1, n - n_found) if n_found < n else 1.0
    return float(low), float(high)


def rate_row(what: str, found: list[str], n: int) -> list[str]:
    """Return a row of a table: how many of n meshes were found, the interval, and which."""
    low, high = interval(len(found), n)
    return [what, f"{len(found)} of {n}", f"{low:.1%} to {high:.1%}", "; ".join(found)]


def random_model(random: np.random.Generator) -> tuple[str, Mesh]:
    """Make a model of at most `MOST` vertices; its name tells how."""
    while True:
        kind = str(random.choice(list(PRIMITIVES)))
        add, _ = PRIMITIVES[kind]
        _empty_file()
        add()
        item = bpy.context.object
        item.scale = random.uniform(0.5, 2, 3)
        bpy.ops.object.transform_apply()
        chosen = [str(each) for each in random.choice(list(MODIFIERS), random.integers(1, 4))]
        for modifier in chosen:
            add_modifier(item, modifier, **MODIFIERS[modifier](random))
        vertices, faces = evaluated(item)
        if 0 < len(faces) and len(vertices) <= MOST:
            return " ".join([kind, *chosen]).lower().replace("_", " "), (vertices, faces)


def _of_primitives() -> list[list[str]]:
    rows = []
    for name, (add, fine) in PRIMITIVES.items():
        for options in ({}, fine) if fine else ({},):
            _empty_file()
            add(**options)
            vertices, faces = evaluated(bpy.context.object)
            moves = np.abs(denoise(vertices, faces).positions - vertices)
            shown = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in options.items())
            rows.append([f"{name}, {shown or 'default'}", str(len(vertices)), f"{moves.max():.4f}"])
    return rows


def _is_changed(vertices: FloatArray, faces: Faces) -> bool:
    return not np.array_equal(denoise(vertices, faces).positions, vertices)


def _empty_file() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)


if __name__ == "__main__":
    main()
