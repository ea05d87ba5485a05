"""The job type for Flamenco: what it asks for, and the tasks that it makes of it."""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace

import pytest
from support.flamenco import CompileError, JobType, check_definition

from adaptive_fairing import defaults
from adaptive_fairing.cli import main as cli
from adaptive_fairing.core import FairingSettings

SCRIPT = Path(__file__).resolve().parents[2] / "flamenco" / "adaptive_fairing.js"
MESHES = {"input": "/farm/scans", "output_dir": "/farm/out", "mesh_count": 25}
ANIMATION = {
    "kind": "animation", "input": "/farm/dance.abc", "output_dir": "/farm/out", "frames": "1-50",
}  # fmt: skip


@pytest.fixture(scope="module")
def job_type():
    return JobType(SCRIPT)


def program_arguments(task):
    """Arguments that the program gets from a task."""
    arguments = task.blender_arguments()
    return arguments[arguments.index("-c") + 2 :]


def parsed(task):
    """What the program's own parser makes of a task; it must not refuse it."""
    return cli.build_parser().parse_args(program_arguments(task))


def test_the_definition_is_one_that_a_manager_takes(job_type):
    check_definition(job_type.definition)
    assert job_type.definition["label"] == "Adaptive Fairing"


def test_every_setting_is_described(job_type):
    for setting in job_type.definition["settings"]:
        assert setting["description"]


def test_the_expressions_give_values_of_their_type(job_type, tmp_path):
    for name in ("a.ply", "b.ply"):
        (tmp_path / name).touch()
    scene = SimpleNamespace(frame_start=3, frame_end=7)
    names = {
        "Path": Path,
        "abspath": lambda path: path,
        "settings": SimpleNamespace(input=str(tmp_path)),
        "C": SimpleNamespace(scene=scene),
    }
    expressions = {
        setting["key"]: setting["eval"]
        for setting in job_type.definition["settings"]
        if "eval" in setting
    }
    values = {key: eval(text, names) for key, text in expressions.items()}
    assert values == {"mesh_count": 2, "frames": "3-7"}


def test_choices_and_defaults_are_the_programs(job_type):
    by_key = {setting["key"]: setting for setting in job_type.definition["settings"]}
    options = {
        option: action for action in cli.build_parser()._actions for option in action.option_strings
    }
    # Afresh: other tests put another method there for a while.
    method = runpy.run_path(defaults.__file__)["METHOD"]
    start = FairingSettings(method=method)
    density = next(name for name, value in cli.DENSITIES.items() if value == start.density)
    translated = {"method": cli.METHOD_NAMES[method], "density": density}
    for key in ("method", "strength", "tau", "steps", "density", "boundary"):
        action = options[f"--{key}"]
        assert by_key[key]["default"] == translated.get(key, getattr(start, key))
        if action.choices:
            assert sorted(by_key[key]["choices"]) == sorted(action.choices)


@pytest.mark.parametrize(
    ("count", "chunk_size", "n_tasks"),
    [(25, 10, 3), (20, 10, 2), (1, 10, 1), (0, 10, 1), (7, 1, 7)],
)
def test_there_is_a_task_for_every_chunk_and_one_that_merges(job_type, count, chunk_size, n_tasks):
    *fairing, merge = job_type.compile(**{**MESHES, "mesh_count": count}, chunk_size=chunk_size)
    assert len(fairing) == n_tasks
    assert merge.dependencies == list(range(n_tasks))
    assert all(task.dependencies == [] for task in fairing)
    shards = [parsed(task).shard for task in fairing]
    assert shards == [f"{i}/{n_tasks}" for i in range(1, n_tasks + 1)]
    assert all(task.commands[0]["totalStepCount"] > 0 for task in [*fairing, merge])


def test_the_steps_of_the_tasks_are_the_frames(job_type):
    *fairing, _ = job_type.compile(**{**ANIMATION, "frames": "1-30, 41-60"}, chunk_size=10)
    assert [task.commands[0]["totalStepCount"] for task in fairing] == [10] * 5


def test_all_tasks_ask_for_the_same_results(job_type):
    """Otherwise the last one does not find what the others have made."""
    tasks = job_type.compile(**ANIMATION, keyed_file="/farm/all.blend", steps=7, tau=0.5)
    own = ("shard", "merge", "report", "jobs", "allow_failures", "flamenco", "output", "memory")
    asked = [
        {key: value for key, value in vars(parsed(task)).items() if key not in own}
        for task in tasks
    ]
    assert all(each == asked[0] for each in asked)
    assert asked[0]["steps"] == 7
    assert asked[0]["tau"] == 0.5
    assert asked[0]["same_strength"]
    assert asked[0]["frames"] == "1-50"
    assert asked[0]["format"] == "ply"


def test_the_program_accepts_what_it_is_given(job_type, tmp_path, monkeypatch):
    """The checks of the program itself, which look at the files as well."""
    (tmp_path / "a_1.ply").touch()
    here = {"input": str(tmp_path), "output_dir": str(tmp_path / "out")}
    keyed = {"keyed_file": str(tmp_path / "all.blend")}
    for settings in (
        here,
        {**here, "format": "obj", "object": "Bean", "memory": "8G", "jobs": 2},
        {**here, "kind": "numbered frames"},
        {**here, **keyed, "kind": "numbered frames", "same_strength": False},
        {**here, "kind": "animation", "frames": "1-5", "input": str(tmp_path / "a_1.ply")},
        {**here, "more_arguments": "--stop-curvature 0.5 --density-passes 2"},
    ):
        for task in job_type.compile(**{"mesh_count": 1, **settings}):
            assert cli.parse(program_arguments(task)).plan is not None


def test_the_extension_is_enabled_before_the_command(job_type):
    arguments = job_type.compile(**MESHES)[0].blender_arguments("-b -y --factory-startup")
    assert arguments[:7] == [
        "-b", "-y", "--factory-startup",
        "--addons", "bl_ext.user_default.adaptive_fairing", "-c", "adaptive_fairing",
    ]  # fmt: skip


def test_a_broken_mesh_fails_the_job_at_its_end_and_no_worker(job_type):
    *fairing, merge = job_type.compile(**MESHES)
    assert all(parsed(task).allow_failures for task in fairing)
    assert not parsed(merge).allow_failures
    *_, merge = job_type.compile(**MESHES, allow_failures=True)
    assert parsed(merge).allow_failures


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({**MESHES, "chunk_size": 0}, "Chunk Size must be at least 1"),
        ({**ANIMATION, "frames": ""}, "An animation needs Frames"),
        ({**MESHES, "keyed_file": "/farm/all.blend"}, "Keyed File is for frames"),
    ],
)
def test_settings_that_make_no_sense_are_refused_at_submission(job_type, settings, message):
    with pytest.raises(CompileError, match=message):
        job_type.compile(**settings)


def test_names_with_spaces_stay_one_argument(job_type):
    task = job_type.compile(**{**MESHES, "input": "/farm/old scans/*.ply"})[0]
    assert program_arguments(task)[0] == "/farm/old scans/*.ply"
