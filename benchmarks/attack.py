"""Run the command line on malformed files of every format, and print what became of them.

    python -m benchmarks.attack [--count 500] [--seed 0] [--alone 40]

The files are made from one mesh: cut, with changed bytes or bits, with other numbers in their text,
with pieces taken out, doubled or filled with zeros. All of them are a batch; those that ended a
worker process, and some others, are run alone as well. Exit status 1 if anything is wrong: a status
other than 0 and 1, a message of several lines, an output that is not whole or not finite, a draft
that is left.
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

import numpy as np

from adaptive_fairing.blender.files.mesh_files import empty_scene, export_mesh, save_blend
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
        for path in chosen:
            problems += run_alone(path, Path(folder))
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
    for suffix in SUFFIXES:
        path = sound / f"mesh{suffix}"
        if suffix == ".blend":
            save_blend(path)
        else:
            export_mesh(item, path, alone=False)
    shutil.copy(sound / "mesh.bin", given)  # the binary buffer of .gltf is found by its name
    files = []
    for number in range(count):
        suffix = SUFFIXES[number % len(SUFFIXES)]
        data = bytearray((sound / f"mesh{suffix}").read_bytes())
        for _ in range(chance.choice([1, 1, 2, 4])):
            chance.choice(ATTACKS)(data, chance)
        path = given / f"{number:04d}{suffix}"
        path.write_bytes(data)
        files.append(path)
    return files


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
    options = ["--format", "ply", "--jobs", "2", "--memory", "8G"]
    run = run_program("denoise", *given, "--out-dir", out, "--report", report, *options)
    outcomes, problems = {}, []
    for mesh in json.loads(report.read_text())["meshes"]:
        name, error = Path(mesh["input"]).name, mesh["error"] or ""
        is_done = mesh["status"] == "done"
        outcomes[name] = FAIRED if is_done else DIED if "was ended" in error else REFUSED
        problems += [f"{name}: {each}" for each in problems_of(out / mesh["output"], is_done)]
    n_failed = sum(outcome != FAIRED for outcome in outcomes.values())
    if run.status != (n_failed > 0):
        problems.append(f"batch: status {run.status}")
    if len(run.messages) != n_failed + 1 + (n_failed > 0):
        problems.append(f"batch: {len(run.messages)} lines for {n_failed} failures")
    return outcomes, problems + drafts_in(out)


def run_alone(path: Path, folder: Path) -> list[str]:
    """Run a file alone; give what was wrong."""
    place = folder / "alone"
    place.mkdir(exist_ok=True)
    output = place / f"{path.name}.ply"
    run = run_program("denoise", path, "-o", output, "--quiet")
    problems = problems_of_run(run)
    if len(run.messages) != run.status:
        problems.append(f"{len(run.messages)} lines")
    problems += problems_of(output, run.status == 0)
    return [f"{path.name} alone: {each}" for each in problems] + drafts_in(place)


def problems_of(output: Path, is_done: bool) -> list[str]:
    """Check that an output is there if it should be, whole and finite."""
    if not is_done:
        return ["output in spite of an error"] if output.exists() else []
    try:
        mesh = read_mesh_file(output)
    except Exception as error:  # whatever it is, the file is not whole
        return [str(error)]
    return [] if np.isfinite(mesh.vertices).all() else ["not finite"]


def drafts_in(folder: Path) -> list[str]:
    """Name what was left of files that were not finished."""
    return [f"left: {path.name}" for path in folder.rglob(".*")]


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
