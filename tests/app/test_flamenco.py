"""A Flamenco job run task by task with the real program, two at once, one of them killed midway."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from support.flamenco import JobType, Task  # noqa: E402
from support.meshes import random_closed  # noqa: E402

pytestmark = pytest.mark.app

SCRIPT = ROOT / "flamenco" / "adaptive_fairing.js"
N_MESHES = 12
SETTINGS = {"algorithm": "fair", "steps": 2, "tau": 0.008, "density": "area"}
ARGUMENTS = ["--steps", "2", "--tau", "0.008", "--density", "area"]


class Farm:
    """Runs the tasks of a job as a manager has them run: what others need first."""

    def __init__(self, app) -> None:
        self.app = app
        self.codes: dict[str, list[int]] = {}

    def run(self, tasks: list[Task]) -> None:
        """Run tasks at the same time, each in a Blender of its own."""
        threads = [threading.Thread(target=self._run, args=(task,)) for task in tasks]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def _run(self, task: Task) -> None:
        code = self.app.blender(task.blender_arguments())
        self.codes.setdefault(task.name, []).append(code)


def write_obj(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n")


def results(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def kill_when_there_is_a_result(folder: Path, shard: str) -> bool:
    """Kill the Blender of a task once it has written something; tell whether it was hit."""
    while True:
        for process in psutil.process_iter(["name", "cmdline"]):
            words = process.info["cmdline"] or []
            if process.info["name"] == "blender" and shard in words and str(folder) in words:
                if any(folder.glob("*.obj")):
                    process.kill()
                    return True
        time.sleep(0.02)


@pytest.fixture(scope="module")
def given(app) -> Path:
    """A folder of meshes, of which one is none."""
    folder = app.directory / "flamenco" / "given"
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(N_MESHES - 1):
        write_obj(folder / f"mesh_{seed:02d}.obj", *random_closed(seed))
    (folder / "broken.obj").write_text("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    return folder


@pytest.fixture(scope="module")
def farmed(app, given, printed) -> dict:
    """Run the job: two tasks at once, one killed midway and run again, then the merge."""
    output = given.with_name("farmed")
    tasks = JobType(SCRIPT).submit(
        input=str(given), output_dir=str(output), mesh_count=N_MESHES, chunk_size=6, **SETTINGS
    )
    *fairing, merge = tasks
    farm = Farm(app)
    killer = threading.Thread(target=kill_when_there_is_a_result, args=(output, "1/2"), daemon=True)
    killer.start()
    farm.run(fairing)
    killer.join(timeout=10)
    after_kill = results(output)
    farm.run([fairing[0]])
    farm.run([merge])
    return {
        "folder": output, "codes": farm.codes, "after kill": after_kill, "tasks": tasks,
        "printed": printed(),
        "summary": json.loads((output / "summary.json").read_text()),
    }  # fmt: skip


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """Keep what the programs of this module print, whatever thread has started them."""
    sys.stdout.flush()
    path = tmp_path_factory.mktemp("printed") / "stdout"
    kept = os.dup(1)
    with path.open("wb") as stream:
        os.dup2(stream.fileno(), 1)
    yield lambda: path.read_text(errors="replace")
    os.dup2(kept, 1)
    os.close(kept)


@pytest.fixture(scope="module")
def alone(app, given) -> dict[str, bytes]:
    """The same meshes as a batch on one machine, without Flamenco."""
    folder = given.with_name("alone")
    command = [
        "-c",
        "adaptive_fairing",
        "fair",
        given,
        "--out-dir",
        folder,
        "--jobs",
        "2",
        *ARGUMENTS,
    ]
    assert app.blender(command) == 1, "one mesh is broken"
    return results(folder)


def test_the_tasks_end_as_they_should(farmed):
    """A broken mesh is told by the summary; being killed is no success."""
    first, again = farmed["codes"]["fair-1-of-2"]
    assert first != 0
    assert again == 0
    assert farmed["codes"]["fair-2-of-2"] == [0]
    assert farmed["codes"]["merge"] == [0]


def test_the_killed_task_had_left_whole_results_only(farmed, alone):
    left = {name: data for name, data in farmed["after kill"].items() if not name.startswith(".")}
    n_done = len([name for name in left if name.endswith(".obj")])
    assert 0 < n_done < N_MESHES - 1, "the kill came too early or too late"
    assert all(data == alone[name] for name, data in left.items())


def test_the_results_are_those_of_a_batch_on_one_machine(farmed, alone):
    found = results(farmed["folder"])
    del found["summary.json"]
    assert found.keys() == alone.keys()
    assert len([name for name in found if name.endswith(".obj")]) == N_MESHES - 1
    assert found == alone


def test_the_summary_names_every_mesh(farmed):
    counts = farmed["summary"]["counts"]
    assert counts == {
        "meshes": N_MESHES, "done": 0, "skipped": N_MESHES - 1, "failed": 1, "missing": 0,
    }  # fmt: skip
    (failed,) = [mesh for mesh in farmed["summary"]["meshes"] if mesh["status"] == "failed"]
    assert failed["output"] == "broken.obj"
    assert "not finite" in failed["error"]


def test_every_mesh_was_a_line_that_flamenco_counts(farmed):
    lines = [line for line in farmed["printed"].splitlines() if line.startswith("Time: ")]
    told = {line.split(" | ")[1].split(":")[0] for line in lines}
    assert told == {f"mesh_{seed:02d}.obj" for seed in range(N_MESHES - 1)} | {"broken.obj"}
    assert all(task.commands[0]["totalStepCount"] == 6 for task in farmed["tasks"][:-1])


def test_frames_become_one_keyed_object_on_the_farm(app, given):
    """Numbered files through the farm and on one machine: the same frames."""
    frames = given.with_name("frames")
    frames.mkdir(exist_ok=True)
    vertices, faces = random_closed(1)
    for number in range(1, 5):
        stretched = vertices * [1 + 0.2 * number, 1, 1]
        write_obj(frames / f"frame_{number}.obj", stretched, faces)
    output, keyed = given.with_name("faired"), given.with_name("all.blend")
    *fairing, merge = JobType(SCRIPT).submit(
        kind="numbered frames", input=str(frames), output_dir=str(output), mesh_count=4,
        chunk_size=2, keyed=str(keyed), **SETTINGS,
    )  # fmt: skip
    farm = Farm(app)
    farm.run(fairing)
    farm.run([merge])
    assert farm.codes == {"fair-1-of-2": [0], "fair-2-of-2": [0], "merge": [0]}
    one = given.with_name("one machine")
    command = [
        "-c", "adaptive_fairing", "fair", frames, "--sequence", "--same-strength", "--out-dir", one,
        "--format", "ply", *ARGUMENTS,
    ]  # fmt: skip
    assert app.blender(command) == 0
    found = results(output)
    del found["summary.json"]
    assert found == results(one)
    assert sorted(found) == [f"frame_{number}.ply" for number in range(1, 5)]
    seen = app.script("inspect", keyed, given.parent)
    assert seen["keys"] == [f"Frame {number}" for number in range(1, 5)]
    assert seen["absolute"]
    assert seen["animated"]
