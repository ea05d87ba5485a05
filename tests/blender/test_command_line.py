"""The command line: arguments, exit status, messages, what is on which stream."""

import ctypes
import json
import os
import re
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import bpy
import pytest
from support.meshes import bumpy_disc, icosphere, noisy_ball, random_closed
from support.objects import add_object

from adaptive_fairing.blender.files.mesh_files import (
    empty_scene,
    export_mesh,
    import_mesh,
    save_blend,
)
from adaptive_fairing.cli import main as cli
from adaptive_fairing.cli import runs
from adaptive_fairing.core import FairingSettings
from adaptive_fairing.files.formats import MESH_FORMATS
from adaptive_fairing.version import program_version

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def noisy(tmp_path):
    path = tmp_path / "noisy.ply"
    export_mesh(add_object(*random_closed(seed=1)), path, alone=True)
    return path


def run(*arguments, **options):
    """Run the program in a process of its own, as a user does."""
    return subprocess.run(
        [sys.executable, "-m", "adaptive_fairing", *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


def error_of(capsys, *arguments, status):
    """Run in this process; check the status and that the message is one line; give the line."""
    assert cli.main([str(argument) for argument in arguments]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(r"adaptive-fairing: error: .+\n", err)
    return err


def test_the_main_job_end_to_end(noisy, tmp_path):
    out, report = tmp_path / "out.blend", tmp_path / "r.json"
    options = ["--steps", 2, "--report", report]
    result = run("fair", noisy, "-o", out, *options)
    assert result.returncode == 0
    assert result.stdout == ""
    assert result.stderr.endswith(f"wrote {tmp_path / 'out.blend'}\n")
    obj = import_mesh(tmp_path / "out.blend", "noisy")
    assert len(obj.data.shape_keys.key_blocks) == 3
    assert len(json.loads((tmp_path / "r.json").read_text())["steps"]) == 2


@pytest.mark.parametrize("options", [(), ("--no-denoised",)])
def test_the_result_of_denoise_stands_beside_unless_it_is_left_out(tmp_path, options):
    export_mesh(add_object(*noisy_ball(4)), tmp_path / "ball.ply", alone=True)
    arguments = ["fair", str(tmp_path / "ball.ply"), "-o", str(tmp_path / "out.blend"), *options]
    assert cli.main(arguments) == cli.DONE
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    beside = [] if options else ["ball denoised"]
    assert [obj.name for obj in bpy.context.scene.objects] == ["ball", *beside]


@pytest.mark.parametrize("suffix", [".obj", ".glb", ".fbx", ".usda", ".abc", ".stl", ".blend"])
def test_standard_output_stays_empty(noisy, tmp_path, capfd, suffix):
    """Whatever importers and exporters print by Python or by C, whose buffer is full later."""
    one, two = tmp_path / f"one{suffix}", tmp_path / f"two{suffix}"
    for given, out in ((noisy, one), (one, two)):
        arguments = ["fair", str(given), "-o", str(out), "--steps", "1", "--no-denoised"]
        assert cli.main(arguments) == 0
    ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None).fflush(None)
    assert capfd.readouterr().out == ""


@pytest.mark.parametrize(
    ("arguments", "end"),
    [
        (["--steps", "2"], "2 steps (all done)"),
        (["--stop-curvature", "100"], "1 steps (ended by --stop-curvature)"),
        (["--stop-rate", "1e9"], "1 steps (ended by --stop-rate)"),
    ],
)
def test_the_summary_says_why_the_run_ended(noisy, tmp_path, capsys, arguments, end):
    out = tmp_path / "out.ply"
    assert cli.main(["fair", str(noisy), "-o", str(out), *arguments]) == 0
    shown = capsys.readouterr().err
    assert re.match(
        rf"adaptive-fairing: 42 vertices, {re.escape(end)}, tau \S+, curvature energy ", shown
    )
    assert shown.endswith(f"; wrote {out}\n")


def test_the_summary_of_denoise_tells_noise_and_radius(tmp_path, capsys):
    path = tmp_path / "ball.ply"
    export_mesh(add_object(*noisy_ball()), path, alone=True)
    assert cli.main(["denoise", str(path), "-o", str(tmp_path / "out.ply")]) == 0
    shown = capsys.readouterr().err
    assert re.match(
        r"adaptive-fairing: 642 vertices, noise \S+, smoothing radius \S+ local edge lengths, "
        r"curvature energy \S+ times the input's, largest displacement \S+; wrote ",
        shown,
    )


def test_what_the_format_cannot_hold_is_said(tmp_path, capsys):
    obj = add_object(*random_closed(seed=1))
    obj.data.uv_layers.new(name="UVMap").uv[0].vector = (0.3, 0.7)
    save_blend(tmp_path / "in.blend")
    assert cli.main(["denoise", str(tmp_path / "in.blend"), "-o", str(tmp_path / "out.ply")]) == 0
    assert "adaptive-fairing: note: UVs are left out" in capsys.readouterr().err


def test_too_little_memory_is_status_1(capsys, noisy, tmp_path, monkeypatch):
    def give_up(*arguments, **options):
        raise MemoryError

    monkeypatch.setattr("adaptive_fairing.blender.jobs.solve.fair_steps", give_up)
    line = error_of(
        capsys, "fair", noisy, "-o", tmp_path / "o.ply", "--report", tmp_path / "r.json", status=1
    )
    assert "not enough memory for this mesh" in line
    assert json.loads((tmp_path / "r.json").read_text())["error"] == "not enough memory"


def test_quiet_says_nothing(noisy, tmp_path, capfd):
    assert cli.main(["denoise", str(noisy), "-o", str(tmp_path / "out.ply"), "--quiet"]) == 0
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("algorithm", "name"), [("denoise", "denoised"), ("fair", "faired"), ("refine", "refined")]
)
def test_default_output_lies_beside_the_input_and_bears_the_commands_name(noisy, algorithm, name):
    assert cli.main([algorithm, str(noisy), "--quiet"]) == 0
    assert noisy.with_name(f"noisy_{name}.blend").is_file()


def test_names_of_files_may_be_in_capitals(tmp_path):
    path = tmp_path / "NOISY.PLY"
    export_mesh(add_object(*random_closed(seed=1)), path, alone=True)
    assert (
        cli.main(["fair", str(path), "-o", str(tmp_path / "OUT.OBJ"), "--quiet", "--steps", "1"])
        == 0
    )
    assert (tmp_path / "OUT.OBJ").is_file()


def test_a_missing_file_is_status_1(capsys, tmp_path):
    line = error_of(capsys, "denoise", tmp_path / "no.ply", status=1)
    assert "no.ply: there is no such file" in line


def test_several_meshes_without_a_name_are_status_1(capsys, tmp_path):
    for name in ("One", "Two"):
        add_object(*random_closed(seed=1), name=name)
    save_blend(tmp_path / "two.blend")
    line = error_of(capsys, "denoise", tmp_path / "two.blend", status=1)
    assert "two.blend holds 2 meshes: choose one with --object: 'One', 'Two'" in line
    out = tmp_path / "out.blend"
    arguments = [str(tmp_path / "two.blend"), "--object", "Two", "-o", str(out), "--quiet"]
    assert cli.main(["denoise", *arguments]) == 0
    assert import_mesh(out, "Two").data.shape_keys is not None
    assert bpy.data.objects["One"].data.shape_keys is None


def test_an_object_that_is_no_mesh_is_status_1(capsys, tmp_path):
    add_object(*random_closed(seed=1))
    camera = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    bpy.context.scene.collection.objects.link(camera)
    save_blend(tmp_path / "a.blend")
    line = error_of(capsys, "denoise", tmp_path / "a.blend", "--object", "Eye", status=1)
    assert "'Eye' in a.blend is a camera, not a mesh; its meshes are: 'Thing'" in line


def test_a_file_without_a_mesh_is_status_1(capsys, tmp_path):
    save_blend(tmp_path / "a.blend")
    assert "a.blend holds no mesh" in error_of(capsys, "denoise", tmp_path / "a.blend", status=1)


def test_a_solve_that_does_not_converge_is_status_1(capsys, noisy, tmp_path, monkeypatch):
    settings = FairingSettings(cg_max_iterations=1, cg_tolerance=1e-12)
    monkeypatch.setattr(runs, "settings_of", lambda arguments: settings)
    line = error_of(capsys, "fair", noisy, "-o", tmp_path / "out.ply", status=1)
    assert "step 1 did not converge: residual" in line
    assert "choose a smaller radius or tau" in line


@pytest.mark.parametrize("target", ["missing/out.ply", "folder.ply"])
def test_an_unwritable_output_is_status_1(capsys, noisy, tmp_path, target):
    (tmp_path / "folder.ply").mkdir()
    line = error_of(capsys, "denoise", noisy, "-o", tmp_path / target, status=1)
    assert "cannot write" in line


@contextmanager
def full_disk():
    """Let no file of this process grow beyond a few kilobytes, as on a disk that runs full."""
    resource = pytest.importorskip("resource")  # does not exist on Windows
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("suffix", [".blend", *MESH_FORMATS])
def test_a_full_disk_is_status_1_and_leaves_the_old_file(capsys, tmp_path, suffix):
    given = tmp_path / "given"
    given.mkdir()
    export_mesh(add_object(*icosphere(3)), given / "in.ply", alone=True)
    out = tmp_path / f"out{suffix}"
    out.write_text("old")
    with full_disk():
        line = error_of(capsys, "fair", given / "in.ply", "-o", out, "--steps", 1, status=1)
    assert line == f"adaptive-fairing: error: cannot write {out}: File too large\n"
    assert out.read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["given", out.name]


def test_help_and_version_need_no_blender():
    code = (
        "import sys; sys.modules['bpy'] = sys.modules['numpy'] = sys.modules['scipy'] = None\n"
        "from adaptive_fairing.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    for argument in ("--help", "--version"):
        result = subprocess.run(
            [sys.executable, "-c", code, argument],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        assert result.returncode == 0
        assert result.stderr == ""
    assert result.stdout == f"adaptive-fairing {program_version()}\n"


@pytest.mark.parametrize("module", ["bpy", "scipy"])
def test_a_missing_package_is_status_1_and_named(noisy, module):
    code = (
        f"import sys; sys.modules['{module}'] = None\n"
        "from adaptive_fairing.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    result = subprocess.run(
        [sys.executable, "-c", code, "denoise", str(noisy)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 1
    assert re.fullmatch(rf"adaptive-fairing: error: .*pip install {module}.*\n", result.stderr)


def on_a_terminal(*command):
    """Run with standard error on a terminal; give the status and what the terminal showed."""
    import pty
    import termios

    leader, follower = pty.openpty()
    termios.tcsetwinsize(follower, (24, 120))
    process = subprocess.Popen(
        [sys.executable, *map(str, command)], cwd=ROOT, stdout=subprocess.PIPE, stderr=follower
    )
    os.close(follower)
    shown = b""
    while piece := _read(leader):
        shown += piece
    os.close(leader)
    assert process.stdout.read() == b""
    return process.wait(), shown.decode()


def _read(terminal):
    try:
        return os.read(terminal, 4096)
    except OSError:  # Linux reports a closed terminal as an error
        return b""


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals")
def test_a_terminal_gets_a_progress_bar(noisy, tmp_path):
    options = ["--steps", 3]
    status, shown = on_a_terminal(
        "-m", "adaptive_fairing", "fair", noisy, "-o", tmp_path / "out.ply", *options
    )
    assert status == 0
    assert "fairing: 100%" in shown
    assert "3/3" in shown


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals")
def test_a_terminal_gets_a_progress_bar_of_denoise(tmp_path):
    path = tmp_path / "ball.ply"
    export_mesh(add_object(*noisy_ball()), path, alone=True)
    status, shown = on_a_terminal(
        "-m", "adaptive_fairing", "denoise", path, "-o", tmp_path / "out.ply"
    )
    assert status == 0
    assert "denoising: 100%" in shown


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals")
def test_a_quiet_terminal_gets_none(noisy, tmp_path):
    status, shown = on_a_terminal(
        "-m", "adaptive_fairing", "fair", noisy, "-o", tmp_path / "out.ply", "--quiet"
    )
    assert (status, shown) == (0, "")


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals")
def test_without_tqdm_a_terminal_gets_a_line_per_step(noisy, tmp_path):
    code = (
        "import sys; sys.modules['tqdm'] = None\n"
        "from adaptive_fairing.cli.main import main; sys.exit(main(sys.argv[1:]))"
    )
    options = ["--steps", 3]
    status, shown = on_a_terminal("-c", code, "fair", noisy, "-o", tmp_path / "out.ply", *options)
    assert status == 0
    lines = shown.splitlines()
    assert [line[: len("fairing: step 1 of 3")] for line in lines[:3]] == [
        f"fairing: step {step} of 3" for step in (1, 2, 3)
    ]
    assert len(lines) == 4


def test_ctrl_c_leaves_nothing_behind(capsys, noisy, tmp_path, monkeypatch):
    from adaptive_fairing.blender.jobs import solve

    def interrupt(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(solve, "fair_steps", interrupt)
    out = tmp_path / "out.ply"
    out.write_text("old")
    line = error_of(capsys, "fair", noisy, "-o", out, status=130)
    assert "interrupted: no output was written" in line
    assert out.read_text() == "old"


@pytest.mark.parametrize("old", [True, False])
def test_ctrl_c_after_the_output_was_written_says_so(capsys, noisy, tmp_path, monkeypatch, old):
    from adaptive_fairing.blender.jobs import file_job

    def interrupt(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(file_job, "write_report", interrupt)
    out = tmp_path / "out.ply"
    if old:
        out.write_text("old")
    line = error_of(capsys, "fair", noisy, "-o", out, "--report", tmp_path / "r", status=130)
    assert line.endswith(f"interrupted: {out} was already written\n")
    assert out.read_bytes().startswith(b"ply")


def test_a_second_run_in_one_process_starts_afresh(noisy, tmp_path):
    empty_scene()
    export_mesh(add_object(*bumpy_disc(seed=0)), tmp_path / "disc.ply", alone=True)
    for name in ("noisy", "disc"):
        source, out = tmp_path / f"{name}.ply", tmp_path / f"{name}.blend"
        assert cli.main(["denoise", str(source), "-o", str(out), "--quiet"]) == 0
    import_mesh(tmp_path / "disc.blend")
    assert [obj.name for obj in bpy.data.objects] == ["disc"]
