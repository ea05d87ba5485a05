"""The job type for Flamenco: what it asks for, and the tasks that it makes of it."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.flamenco import CompileError, JobType, check_definition

from adaptive_fairing.batch.inputs import parse_frames
from adaptive_fairing.cli.arguments import parse
from adaptive_fairing.cli.options import build_parsers
from adaptive_fairing.core import DenoiseSettings, FairingSettings
from adaptive_fairing.core.diffusion.settings import DENSITIES, SCHEMES
from adaptive_fairing.core.problem.setting_checks import BOUNDARIES
from adaptive_fairing.files.report import settings_record

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
    program, _ = build_parsers()
    return program.parse_args(program_arguments(task))


def test_the_definition_is_one_that_a_manager_takes(job_type):
    check_definition(job_type.definition)
    assert job_type.definition["label"] == "Adaptive Fairing"


def test_every_setting_is_described(job_type):
    for setting in job_type.definition["settings"]:
        assert setting["description"]


@pytest.mark.parametrize("pattern", ["scans", "scans/**/*.ply", "//scans", "//scans/*.*", "scans/"])
def test_mesh_files_of_a_folder_or_a_pattern_are_counted(job_type, tmp_path, pattern):
    for name in (
        "scans/a.ply", "scans/B.PLY", "scans/deep/c.ply", "scans/notes.txt", "scans/.draft.ply",
        "scans/summary.json", "scans/fairing_records/a.ply.json", "scans/[odd].ply",
    ):  # fmt: skip
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    given = pattern if pattern.startswith("//") else str(tmp_path / pattern)
    expected = {"scans/**/*.ply": 3, "//scans/*.*": 3}.get(pattern, 4)
    assert job_type.evaluate("mesh_count", {"input": given}, tmp_path) == expected


def test_the_frames_are_the_scenes(job_type):
    assert job_type.evaluate("frames", {}) == "3-7"


def test_paths_may_start_at_the_blend_file(job_type):
    """As the add-on evaluates them, visible on the manager's web pages."""
    by_key = {setting["key"]: setting for setting in job_type.definition["settings"]}
    for key in ("input_path", "output_path", "keyed_file"):
        assert by_key[key]["visible"] == "web"
    task, merge = job_type.submit(
        kind="numbered frames", input="//scans/*.ply", output_dir="//out", keyed="//all.blend",
        mesh_count=1, blend_folder="/farm/shot",
    )  # fmt: skip
    for each in (task, merge):
        assert parsed(each).input == ["/farm/shot/scans/*.ply"]
        assert parsed(each).out_dir == Path("/farm/shot/out")
    assert parsed(merge).output == Path("/farm/shot/all.blend")
    assert parsed(merge).report == Path("/farm/shot/out/summary.json")


def test_choices_and_defaults_are_the_programs(job_type):
    by_key = {setting["key"]: setting for setting in job_type.definition["settings"]}
    for settings in (FairingSettings(), DenoiseSettings()):
        for key, default in settings_record(settings)["settings"].items():
            if key in by_key:
                assert by_key[key]["default"] == (default or 0.0)
    assert by_key["scheme"]["choices"] == [*SCHEMES]
    assert by_key["density"]["choices"] == [*DENSITIES]
    assert by_key["boundary"]["choices"] == [*BOUNDARIES]
    assert by_key["algorithm"]["choices"] == ["denoise", "fair"]


@pytest.mark.parametrize(
    ("algorithm", "own", "others"),
    [
        ("denoise", {"strength": 0.5}, {"scheme", "radius", "tau", "steps", "density"}),
        ("fair", {"scheme": "tensor", "tau": 0.5, "radius": None}, {"strength"}),
        ("fair", {"radius": 0.75, "tau": None, "steps": 7, "density": "area"}, {"strength"}),
    ],
)
def test_only_settings_of_the_algorithm_are_passed(job_type, algorithm, own, others):
    """The program refuses the others."""
    given = {key: value for key, value in own.items() if value is not None}
    for task in job_type.submit(**MESHES, algorithm=algorithm, **given):
        arguments = vars(parsed(task))
        assert arguments["algorithm"] == algorithm
        assert own.items() <= arguments.items()
        assert not others & arguments.keys()


def test_what_was_not_sent_has_its_default(job_type):
    """A job may come from another program than the add-on."""
    sent = {"input": "/farm/scans", "output_dir": "/farm/out"}
    bare, full = job_type.compile(**sent), job_type.submit(**sent)
    assert [program_arguments(task) for task in bare] == [program_arguments(task) for task in full]


@pytest.mark.parametrize(
    ("count", "chunk_size", "n_tasks"),
    [(25, 10, 3), (20, 10, 2), (1, 10, 1), (0, 10, 1), (7, 1, 7)],
)
def test_there_is_a_task_for_every_chunk_and_one_that_merges(job_type, count, chunk_size, n_tasks):
    *fairing, merge = job_type.submit(**{**MESHES, "mesh_count": count}, chunk_size=chunk_size)
    assert len(fairing) == n_tasks
    assert merge.dependencies == list(range(n_tasks))
    assert all(task.dependencies == [] for task in fairing)
    shards = [parsed(task).shard for task in fairing]
    assert shards == [f"{i}/{n_tasks}" for i in range(1, n_tasks + 1)]
    assert all(task.commands[0]["totalStepCount"] > 0 for task in [*fairing, merge])


def test_the_steps_of_the_tasks_are_the_frames(job_type):
    *fairing, _ = job_type.submit(**{**ANIMATION, "frames": "1-30, 41-60"}, chunk_size=10)
    assert [task.commands[0]["totalStepCount"] for task in fairing] == [10] * 5


def test_all_tasks_ask_for_the_same_results(job_type):
    """Otherwise the last one does not find what the others have made."""
    tasks = job_type.submit(
        **ANIMATION, keyed="/farm/all.blend", algorithm="fair", steps=7, tau=0.5
    )
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
    keyed = {"keyed": str(tmp_path / "all.blend")}
    for settings in (
        here,
        {**here, "format": "obj", "object": "Bean", "memory": "8G", "jobs": 2},
        {**here, "kind": "numbered frames"},
        {**here, **keyed, "kind": "numbered frames", "same_strength": False},
        {**here, "kind": "animation", "frames": "1-5", "input": str(tmp_path / "a_1.ply")},
        {**here, "algorithm": "fair", "scheme": "uniform", "more_arguments": "--stop-rate 0.5"},
    ):
        for task in job_type.submit(**{"mesh_count": 1, **settings}):
            assert parse(program_arguments(task)).plan is not None


def test_the_extension_is_enabled_before_the_command(job_type):
    arguments = job_type.submit(**MESHES)[0].blender_arguments("-b -y --factory-startup")
    assert arguments[:7] == [
        "-b", "-y", "--factory-startup",
        "--addons", "bl_ext.user_default.adaptive_fairing", "-c", "adaptive_fairing",
    ]  # fmt: skip


def test_a_broken_mesh_fails_no_task_unless_that_is_asked_for(job_type):
    """A merge that fails is tried by every worker, and then the job waits for others for ever."""
    assert all(parsed(task).allow_failures for task in job_type.submit(**MESHES))
    *fairing, merge = job_type.submit(**MESHES, fail_on_error=True)
    assert all(parsed(task).allow_failures for task in fairing)
    assert not parsed(merge).allow_failures


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"chunk_size": 0}, "Chunk Size must be at least 1"),
        ({"jobs": 0}, "Worker Processes must be at least 1"),
        ({"steps": -3}, "Steps must be at least 1"),
        ({"radius": 0.0}, "Radius must be above 0"),
        ({"tau": -1.0}, "Tau must be above 0, or 0 to take Radius"),
        ({"strength": -1.0}, "Strength must be above 0"),
        ({"input": ""}, "Input is missing: give a folder, a pattern or a file"),
        ({"input": None}, "Input is missing: give a folder, a pattern or a file"),
        ({"output_dir": ""}, "Output Folder is missing"),
        ({"algorithm": "magic"}, 'Algorithm is "magic", it must be one of: denoise, fair'),
        ({"scheme": "magic"}, 'Scheme is "magic", it must be one of: timestep, tensor, uniform'),
        ({"memory": "much"}, 'Memory is "much": give a size such as 8G, or nothing'),
        ({"format": "doc"}, 'Format is "doc", it must be one of: .blend .obj .ply .stl .glb .gltf '
         ".fbx .usd .usda .usdc .usdz .abc"),
        ({"kind": "animation"}, "An animation needs Frames, such as 1-50"),
        ({"kind": "animation", "frames": "10-1"}, 'Frames is "10-1": invalid range "10-1"'),
        ({"kind": "animation", "frames": "a-b"}, 'Frames is "a-b": invalid range "a-b"'),
        ({"kind": "numbered frames", "format": "blend"},
         "Format: frames are written as mesh files, not as .blend"),
        ({"keyed_file": "/farm/all.blend"},
         "Keyed File is for frames: single meshes do not become one object"),
        ({"kind": "numbered frames", "keyed_file": "/farm/all.ply"},
         "Keyed File must be the name of a .blend file"),
        ({"kind": "numbered frames", "keyed_file": "/farm/all.blend", "format": "obj"},
         "Format must be ply, or nothing, with a Keyed File"),
    ],
)  # fmt: skip
def test_settings_that_make_no_sense_are_refused_at_submission(job_type, settings, message):
    """In these very words: a text is thrown, not an error with its trace."""
    with pytest.raises(CompileError) as caught:
        job_type.compile(**{**MESHES, **settings})
    assert str(caught.value) == message


@pytest.mark.parametrize("frames", ["1-6", "1..6", " 1..3, 4-6", "6,5,4,3,2,1"])
def test_frames_are_understood_as_flamenco_does(job_type, frames):
    first, second, merge = job_type.submit(**{**ANIMATION, "frames": frames}, chunk_size=3)
    for task in (first, second, merge):
        assert parse_frames(parsed(task).frames) == [1, 2, 3, 4, 5, 6]
    assert [task.commands[0]["totalStepCount"] for task in (first, second)] == [3, 3]


def test_numbers_are_as_they_were_typed(job_type):
    """The add-on sends single precision."""
    task, _ = job_type.submit(**{**MESHES, "mesh_count": 1}, algorithm="fair", tau=0.0107)
    assert "0.0107" in program_arguments(task)
    task, _ = job_type.submit(**{**MESHES, "mesh_count": 1}, strength=0.7)
    assert "0.7" in program_arguments(task)


def test_names_with_spaces_stay_one_argument(job_type):
    task = job_type.submit(**{**MESHES, "input": "/farm/old scans/*.ply"})[0]
    assert program_arguments(task)[1] == "/farm/old scans/*.ply"
