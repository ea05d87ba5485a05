"""Run the command line on malformed and odd files of every format, and print what became of them.

    python -m benchmarks.attack [--count 500] [--seed 0] [--alone 40]

The files are made from one mesh: as it is, cut, with changed bytes or bits, with other numbers in
their text, with pieces taken out, doubled or filled with zeros. All of them are a batch; those that
ended a worker process, and some others, are run alone as well, to outputs of all formats. Where the
outputs go, other files have the names of what exporters write beside them. Exit status 1 if
anything is wrong: a status other than 0 and 1, a message of several lines, an output that is not
whole or not finite, a file that is changed, or new without an output that names it.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import shutil
import sys
import tempfile
from collections import Counter, defaultdict
from pathlib import Path
from urllib.parse import unquote

import bpy
import numpy as np

from adaptive_fairing.batch.plan import RECORDS
from adaptive_fairing.blender.files.mesh_files import empty_scene, export_mesh, save_blend
from adaptive_fairing.files.inspection import inspect
from tests.support.folders import contents_of
from tests.support.objects import add_rich_object

from .corpus import read_mesh_file
from .measuring import table
from .program import problems_of_run, run_program

SUFFIXES = (
    ".obj", ".ply", ".stl", ".glb", ".gltf", ".fbx", ".usda", ".usdc", ".usdz", ".abc", ".blend",
)  # fmt: skip
FAIRED, REFUSED, DIED = "faired", "refused", "worker died"


def main() -> int:
    """Make the files, run them, print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--alone", type=int, default=40, help="how many to run alone as well")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        given = make_files(Path(folder), options.count, random.Random(options.seed))
        outcomes, problems = run_batch(given, Path(folder))
        died = [path for path in given if outcomes.get(path.name) == DIED]
        rest = [path for path in given if path not in died]
        chosen = died + random.Random(options.seed).sample(rest, min(options.alone, len(rest)))
        for number, path in enumerate(chosen):
            suffix = SUFFIXES[number % len(SUFFIXES)]
            problems += run_alone(path, Path(folder), suffix)
        print_table(outcomes)
    print(f"\n{len(given)} files, {len(chosen)} of them alone as well; {len(problems)} problems")
    print("\n".join(problems))
    return 1 if problems else 0


def make_files(folder: Path, count: int, chance: random.Random) -> list[Path]:
    """Make malformed files, as many of each format."""
    sound, given = folder / "sound", folder / "given"
    sound.mkdir()
    given.mkdir()
    empty_scene()
    item = add_rich_object()
    add_texture(item)
    for suffix in SUFFIXES:
        path = sound / f"mesh{suffix}"
        if suffix == ".blend":
            save_blend(path)
        else:
            export_mesh(item, path, alone=False)
    for name in ("mesh.bin", "wood.png"):  # the .gltf files find them by their names
        shutil.copy(sound / name, given)
    files = []
    for number in range(count):
        suffix = SUFFIXES[number % len(SUFFIXES)]
        data = bytearray((sound / f"mesh{suffix}").read_bytes())
        for _ in range(chance.choice([0, 1, 1, 2, 4])):
            chance.choice(ATTACKS)(data, chance)
        path = given / f"{number:04d}{suffix}"
        path.write_bytes(data)
        files.append(path)
    return files


def add_texture(obj: bpy.types.Object) -> None:
    """Give the first material of an object a small picture as its colour."""
    image = bpy.data.images.new("wood", 4, 4)
    image.pack()
    material = obj.data.materials[0]
    material.use_nodes = True
    nodes = material.node_tree.nodes
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])


def _cut(data: bytearray, chance: random.Random) -> None:
    del data[int(len(data) * chance.random()) :]


def _flip_bits(data: bytearray, chance: random.Random) -> None:
    for _ in range(chance.choice([1, 3, 30])):
        if data:
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)


def _change_head(data: bytearray, chance: random.Random) -> None:
    for _ in range(4):
        if data:
            data[chance.randrange(min(len(data), 300))] = chance.choice([0, 1, 127, 128, 255])


def _lie(data: bytearray, chance: random.Random) -> None:
    """Replace a number in text; in binary files four bytes by a large number."""
    numbers = list(re.finditer(rb"(?<![\w.])\d+(?:\.\d+)?(?![\w.])", data[:100_000]))
    if numbers:
        start, end = chance.choice(numbers).span()
        lies = [b"0", b"-1", b"4000000000", b"nan", b"1e400", b"many", b"99999999999999999999"]
        data[start:end] = chance.choice(lies)
    elif len(data) > 4:
        start = chance.randrange(len(data) - 4)
        data[start : start + 4] = chance.choice([b"\xff\xff\xff\x7f", b"\xff" * 4, bytes(4)])


def _take_out(data: bytearray, chance: random.Random) -> None:
    start = chance.randrange(len(data) + 1)
    del data[start : start + chance.choice([1, 4, 100])]


def _double(data: bytearray, chance: random.Random) -> None:
    start = chance.randrange(len(data) + 1)
    data[start:start] = data[start : start + chance.choice([1, 10, 1000])]


def _zero(data: bytearray, chance: random.Random) -> None:
    start = chance.randrange(len(data) + 1)
    end = min(start + chance.choice([4, 64, 4096]), len(data))
    data[start:end] = bytes(end - start)


ATTACKS = (_cut, _flip_bits, _change_head, _lie, _lie, _take_out, _double, _zero)


def run_batch(given: list[Path], folder: Path) -> tuple[dict[str, str], list[str]]:
    """Run all files as a batch; give what became of each, and what was wrong."""
    out, report = folder / "out", folder / "report.json"
    add_others(out, [path.stem for path in given])
    before = {place: contents_of(place) for place in (given[0].parent, out)}
    options = ["--jobs", "2", "--memory", "8G"]
    run = run_program("denoise", *given, "--out-dir", out, "--report", report, *options)
    outcomes, problems, done = {}, [], []
    for mesh in json.loads(report.read_text())["meshes"]:
        name, error = Path(mesh["input"]).name, mesh["error"] or ""
        is_done = mesh["status"] == "done"
        done += [out / mesh["output"]] if is_done else []
        outcomes[name] = FAIRED if is_done else DIED if "was ended" in error else REFUSED
        problems += [f"{name}: {each}" for each in problems_of(out / mesh["output"], is_done)]
    n_failed = sum(outcome != FAIRED for outcome in outcomes.values())
    if run.status != (n_failed > 0):
        problems.append(f"batch: status {run.status}")
    if len(run.messages) != n_failed + 1 + (n_failed > 0):
        problems.append(f"batch: {len(run.messages)} lines for {n_failed} failures")
    for place, old in before.items():
        problems += unannounced(place, old, done)
    return outcomes, problems


def run_alone(path: Path, folder: Path, suffix: str) -> list[str]:
    """Run a file alone, with an output of another kind; give what was wrong."""
    place = folder / "alone" / path.name
    add_others(place, ["out"])
    before = contents_of(place)
    output = place / f"out{suffix}"
    run = run_program("denoise", path, "-o", output, "--quiet")
    problems = problems_of_run(run)
    if len(run.messages) != run.status:
        problems.append(f"{len(run.messages)} lines")
    problems += problems_of(output, run.status == 0)
    problems += unannounced(place, before, [output] if run.status == 0 else [])
    return [f"{path.name} to {suffix}: {each}" for each in problems]


def add_others(folder: Path, stems: list[str]) -> None:
    """Make files that have the names which exporters give to companions."""
    (folder / "textures").mkdir(parents=True)
    names = [f"{stem}{suffix}" for stem in stems for suffix in (".bin", ".mtl")]
    for name in [*names, "wood.png", "textures/wood.png"]:
        (folder / name).write_text(f"{name} of another program")


def unannounced(folder: Path, before: dict[str, bytes], outputs: list[Path]) -> list[str]:
    """Name the files in a folder that were changed, or are there though no output names them."""
    after = contents_of(folder)
    changed = [name for name in before if after.get(name) != before[name]]
    named = {
        output.relative_to(folder).as_posix() for output in outputs if folder in output.parents
    }
    for name in set(named):
        named |= companions_named_by(folder / name)
    new = [
        name for name in after.keys() - before.keys() - named if not name.startswith(f"{RECORDS}/")
    ]
    return [
        *(f"changed: {name}" for name in changed),
        *(f"nobody has named {name}" for name in sorted(new)),
    ]


def companions_named_by(output: Path) -> set[str]:
    """Names of the files that an output says it needs."""
    if output.suffix == ".gltf":
        scene = json.loads(output.read_bytes())
        items = [*scene.get("buffers", []), *scene.get("images", [])]
        return {unquote(item["uri"]) for item in items}
    if output.suffix == ".obj":
        lines = output.read_text(encoding="utf-8").splitlines()
        return {line[7:] for line in lines if line.startswith("mtllib ")}
    if output.suffix in (".usda", ".usdc"):  # in the latter, names are packed
        return {"textures/wood_2.png"}
    return set()


def problems_of(output: Path, is_done: bool) -> list[str]:
    """Check that an output is there if it should be, whole and finite."""
    if not is_done:
        return ["output in spite of an error"] if output.exists() else []
    try:
        if output.suffix not in (".ply", ".obj", ".stl"):
            inspect(output)
            return []
        mesh = read_mesh_file(output)
    except Exception as error:  # whatever it is, the file is not whole
        return [str(error)]
    return [] if np.isfinite(mesh.vertices).all() else ["not finite"]


def print_table(outcomes: dict[str, str]) -> None:
    """Print how many files of each format came to what."""
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for name, outcome in outcomes.items():
        counts[Path(name).suffix][outcome] += 1
    kinds = (FAIRED, REFUSED, DIED)
    rows = [[suffix, *(str(counts[suffix][kind]) for kind in kinds)] for suffix in SUFFIXES]
    print(table(["format", *kinds], rows))


if __name__ == "__main__":
    sys.exit(main())
