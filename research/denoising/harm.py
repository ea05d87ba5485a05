"""Harm that `denoise` does to models it was not tuned on.

    python -m research.denoising.harm              100 models, 8 decimated shapes, 54 walls
    python -m research.denoising.harm --models 40 --seed 1000

First boolean models: two to four of Blender's primitives, cut from each other or joined, as they
are, rounded, far from the origin, and with jitter.  Counts those with a vertex that moves by more
than a part of the diagonal.  Then shapes decimated by Blender, with noise from little to much, and
thin walls around triply periodic surfaces, as they are printed, without noise and with little.
Counts the results that are further from the clean surface than the noisy mesh is.  Prints tables in
Markdown, with confidence intervals of 95 % after Clopper and Pearson.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import product

import bpy
import numpy as np
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from adaptive_fairing.core import denoise
from benchmarks.measuring import table
from tools.geometry.blender_meshes import add_modifier, evaluated, new_object
from tools.geometry.triangles import Faces, FloatArray

from .false_alarms import rate_row
from .measures import Reference
from .noise import add_noise
from .pairs import CLEAN, made
from .walls import periodic_wall

SHAPES = ("foot", "bracket", "gear", "pawn", "coral", "hills", "mountains", "crocodile")
RATIO = 0.15
NOISES = tuple(
    (kind, size) for kind in ("normal", "uniform") for size in (0.02, 0.05, 0.1, 0.2, 0.4)
)

WALLS = tuple(product(("gyroid", "primitive", "diamond"), (32, 44), (1, 1.5, 2), (0.4, 0.7, 1.2)))
"""Name, cells, periods and thickness of each `periodic_wall`."""
WALL_NOISES = (0.02, 0.03, 0.04)

JITTER = 0.001
"""Of the diagonal."""


def _rounded(vertices: FloatArray, random: np.random.Generator) -> FloatArray:
    return np.round(vertices / np.abs(vertices).max(), 3)


def _far(vertices: FloatArray, random: np.random.Generator) -> FloatArray:
    return (vertices + 1000 * diagonal(vertices)).astype(np.float32).astype(float)


def _jittered(vertices: FloatArray, random: np.random.Generator) -> FloatArray:
    size = JITTER * diagonal(vertices) / np.sqrt(3)
    return vertices + size * random.normal(size=vertices.shape)


VARIANTS: dict[str, tuple[Callable[..., FloatArray], float]] = {
    "as it is": (lambda vertices, random: vertices, 0.001),
    "rounded to three digits": (_rounded, 0.001),
    "a thousand sizes away, in single precision": (_far, 0.001),
    "with jitter of 0.1 % of the diagonal": (_jittered, 0.01),
}
"""Variants of each boolean model, and the fraction of the diagonal not to be exceeded."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", type=int, default=100, help="how many (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the first (default %(default)s)")
    parser.add_argument("--shapes", nargs="*", default=SHAPES, help="to decimate")
    options = parser.parse_args(arguments)
    moved: dict[str, list[str]] = {name: [] for name in VARIANTS}
    for number in tqdm(range(options.seed, options.seed + options.models), unit="model"):
        vertices, faces = boolean_model(np.random.default_rng(number))
        for name, (varied, limit) in VARIANTS.items():
            points = varied(vertices, np.random.default_rng(number))
            part = largest_move(points, faces)
            if part > limit:
                moved[name].append(f"{number} ({part:.2%})")
    rows = [rate_row(f"{name}: > {VARIANTS[name][1]:.1%}", found, options.models)
            for name, found in moved.items()]  # fmt: skip
    print(
        table(("boolean models that moved", "models", "95 % interval of the rate", "which"), rows)
    )
    shapes = ((pair.name, pair.clean, pair.faces) for pair in made(options.shapes, [CLEAN]))
    ratios = dict(tqdm(decimated_runs(shapes), total=len(options.shapes) * len(NOISES)))
    _print_ratios("decimated shapes", ratios)
    still = [_named(*wall) for wall in WALLS if largest_move(*periodic_wall(*wall)) > 0]
    row = rate_row("clean", still, len(WALLS))
    print(f"\n{table(('walls that moved', 'meshes', '95 % interval', 'which'), [row])}")
    runs = len(WALLS) * len(WALL_NOISES)
    _print_ratios("walls", dict(tqdm(wall_runs(WALLS), total=runs)))


def _print_ratios(what: str, ratios: Mapping[str, float]) -> None:
    """Print how many distances after, over before, are above two limits, and their mean."""
    rows = [
        rate_row(f"> {limit}", [f"{run} ({ratio:.2f})" for run, ratio in ratios.items()
                                if ratio > limit], len(ratios))
        for limit in (1.1, 1.5)
    ]  # fmt: skip
    columns = f"{what}: distance after, over before", "runs", "95 % interval", "which"
    print(f"\n{table(columns, rows)}")
    mean = np.exp(np.mean(np.log(list(ratios.values())))) if ratios else np.nan
    print(f"\nGeometric mean of the distance after, over before: {mean:.3f}")


def boolean_model(random: np.random.Generator) -> tuple[FloatArray, Faces]:
    """Cut or join two to four primitives of random size, place and turn."""
    adders = (
        lambda: bpy.ops.mesh.primitive_cube_add(size=2),
        lambda: bpy.ops.mesh.primitive_cylinder_add(vertices=int(random.integers(8, 65))),
        lambda: bpy.ops.mesh.primitive_uv_sphere_add(
            segments=int(random.integers(12, 49)), ring_count=int(random.integers(8, 25))
        ),
        lambda: bpy.ops.mesh.primitive_torus_add(),
        lambda: bpy.ops.mesh.primitive_cone_add(vertices=int(random.integers(8, 49))),
    )
    while True:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        items = []
        for _ in range(random.integers(2, 5)):
            adders[random.integers(len(adders))]()
            item = bpy.context.object
            item.scale = random.uniform(0.4, 1.2, 3)
            item.location = random.uniform(-0.7, 0.7, 3)
            item.rotation_euler = Rotation.random(random_state=random).as_euler("xyz")
            items.append(item)
        for other in items[1:]:
            how = str(random.choice(["DIFFERENCE", "UNION", "INTERSECT"], p=[0.5, 0.35, 0.15]))
            add_modifier(items[0], "BOOLEAN", object=other, operation=how, solver="EXACT")
        vertices, faces = evaluated(items[0])
        if len(faces):
            return vertices, faces


def decimated_runs(
    shapes: Iterable[tuple[str, FloatArray, Faces]],
) -> Iterator[tuple[str, float]]:
    """Denoise decimated shapes with every noise: a name, and the distance after over before."""
    for name, clean, clean_faces in shapes:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        item = new_object(clean, clean_faces)
        add_modifier(item, "DECIMATE", ratio=RATIO)
        vertices, faces = evaluated(item)
        yield from noisy_runs(name, vertices, faces, NOISES)


def wall_runs(
    walls: Iterable[tuple[str, int, float, float]], sizes: Iterable[float] = WALL_NOISES
) -> Iterator[tuple[str, float]]:
    """Denoise walls with little noise: a name, and the distance after over before."""
    noises = [("normal", size) for size in sizes]
    for wall in walls:
        yield from noisy_runs(_named(*wall), *periodic_wall(*wall), noises)


def _named(name: str, cells: int, periods: float, thickness: float) -> str:
    return f"{name}, {cells} cells, {periods:g} periods, {thickness:g} thick,"


def noisy_runs(
    name: str, clean: FloatArray, faces: Faces, noises: Iterable[tuple[str, float]]
) -> Iterator[tuple[str, float]]:
    """Denoise a shape with noises of some kinds and sizes: a name, and the distances' ratio."""
    reference = Reference(clean, faces)
    for number, (kind, size) in enumerate(noises):
        noisy = add_noise(clean, faces, kind, size, number)
        after, before = (
            reference.score(each)["mean"] for each in (denoise(noisy, faces).positions, noisy)
        )
        yield f"{name} {kind} {size}", after / before


def largest_move(vertices: FloatArray, faces: Faces) -> float:
    """Return how far `denoise` moves a vertex at most, over the diagonal."""
    move = denoise(vertices, faces).positions - vertices
    return float(np.linalg.norm(move, axis=1).max()) / diagonal(vertices)


def diagonal(vertices: FloatArray) -> float:
    """Length of the diagonal of the box around vertices (n, 3)."""
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))


if __name__ == "__main__":
    main()
