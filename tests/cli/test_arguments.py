"""Meaning of the arguments, and the errors of meaningless ones."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from adaptive_fairing.cli import options
from adaptive_fairing.cli.arguments import parse, settings_of
from adaptive_fairing.cli.main import main
from adaptive_fairing.core import DenoiseSettings, FairingSettings
from adaptive_fairing.core.denoising.settings import CLEAN, FEATURES
from adaptive_fairing.core.diffusion.settings import DENSITIES, SCHEMES
from adaptive_fairing.core.problem.setting_checks import BOUNDARIES


def settings_for(algorithm, *arguments):
    return settings_of(parse([algorithm, "in.ply", *arguments]))


def error_of(capsys, *arguments, status=2):
    """Run; check the status and that the message is one line; give the line."""
    assert main([str(argument) for argument in arguments]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(r"adaptive-fairing: error: .+\n", err)
    return err


def test_defaults_are_those_of_the_core():
    assert settings_for("denoise") == DenoiseSettings()
    assert settings_for("fair") == FairingSettings()


@pytest.mark.parametrize(
    ("arguments", "field", "value"),
    [
        (["--strength", "0.5"], "strength", 0.5),
        *((["--features", name], "features", name) for name in FEATURES),
        *((["--clean", name], "clean", name) for name in CLEAN),
        *((["--boundary", name], "boundary", name) for name in BOUNDARIES),
        (["--noise-width", "auto"], "width", "auto"),
        (["--noise-width", "8"], "width", 8.0),
        (["--max-deviation", "0.01"], "max_deviation", 0.01),
    ],
)
def test_every_argument_of_denoise_reaches_its_setting(arguments, field, value):
    assert settings_for("denoise", *arguments) == DenoiseSettings(**{field: value})


FAIR_ARGUMENTS = [
    *((["--scheme", word], "method", value) for word, value in SCHEMES.items()),
    *((["--density", word], "density", value) for word, value in DENSITIES.items()),
    *((["--boundary", name], "boundary", name) for name in BOUNDARIES),
    (["--tau", "0.5"], "tau", 0.5),
    (["--radius", "0.7"], "radius", 0.7),
    (["--keep-volume"], "keep_volume", True),
    (["--max-deviation", "0.01"], "max_deviation", 0.01),
    (["--steps", "7"], "steps", 7),
    (["--density-passes", "0"], "density_passes", 0),
    (["--stop-curvature", "0.4"], "stop_curvature", 0.4),
    (["--stop-rate", "2"], "stop_rate", 2.0),
]


@pytest.mark.parametrize(("arguments", "field", "value"), FAIR_ARGUMENTS)
def test_every_argument_of_fair_reaches_its_setting(arguments, field, value):
    assert settings_for("fair", *arguments) == FairingSettings(**{field: value})


@pytest.mark.parametrize(
    ("algorithm", "option", "names"),
    [
        ("denoise", "--features", FEATURES),
        ("denoise", "--clean", CLEAN),
        ("denoise", "--boundary", BOUNDARIES),
        ("fair", "--scheme", SCHEMES),
        ("fair", "--density", DENSITIES),
        ("fair", "--boundary", BOUNDARIES),
    ],
)
def test_help_offers_the_choices_of_the_core(capsys, algorithm, option, names):
    assert main([algorithm, "--help"]) == 0
    assert re.search(rf"\n  {option} {re.escape('|'.join(names))}\s", capsys.readouterr().out)


@pytest.mark.parametrize("name", ["radius", "steps", "density_passes"])
def test_help_tells_the_defaults_of_the_core(name):
    told = help_of("fair", f"--{name.replace('_', '-')}")
    assert told.endswith(f"(default: {getattr(FairingSettings(), name)})")


def test_help_tells_the_default_strength():
    assert help_of("denoise", "--strength").endswith(f"(default: {DenoiseSettings().strength})")


def help_of(algorithm, option):
    _, parsers = options.build_parsers()
    actions = parsers[algorithm]._actions
    return next(action.help for action in actions if option in action.option_strings)


def test_the_help_of_the_program_fits_a_terminal(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    assert main(["--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 45
    assert max(map(len, lines)) <= 100
    for name in ("denoise", "fair", "refine"):
        assert any(line.startswith(f"  {name} ") for line in lines)


@pytest.mark.parametrize("algorithm", ["denoise", "fair", "refine"])
def test_common_options_come_first(capsys, algorithm):
    assert main([algorithm, "--help"]) == 0
    shown = capsys.readouterr().out
    headings = re.findall(r"^(\w.*):$", shown, flags=re.MULTILINE)
    assert headings[:2] == ["positional arguments", "common options"]
    batch = ["many meshes", "frames of one surface"]
    assert headings[-2:] == batch if algorithm != "refine" else not set(batch) & set(headings)


@pytest.mark.parametrize("option", ["--tau", "--steps", "--density", "--stop-rate", "--scheme"])
def test_an_option_of_the_other_command_is_refused(capsys, option):
    line = error_of(capsys, "denoise", "a.ply", option, "4")
    assert f"{option} belongs to fair, not to denoise (see adaptive-fairing denoise" in line


@pytest.mark.parametrize("option", ["--strength", "--features", "--clean"])
def test_an_option_of_denoise_beside_fair_is_refused(capsys, option):
    line = error_of(capsys, "fair", "a.ply", f"{option}=x")
    assert f"{option} belongs to denoise, not to fair (see adaptive-fairing fair" in line


@pytest.mark.parametrize("option", ["--out-dir", "--sequence", "--jobs", "--flamenco"])
def test_batches_are_not_of_refine(capsys, option):
    assert f"{option} belongs to denoise" in error_of(capsys, "refine", "a.ply", option, "x")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "say what to do: denoise, fair or refine, as in adaptive-fairing denoise scan.ply"),
        (["a.ply"], "a.ply: say first what to do: denoise, fair or refine, as in "),
        (["fair.ply"], "fair.ply: say first what to do: denoise, fair or refine, as in "),
        (["--quiet"], "--quiet: say first what to do: denoise, fair or refine, as in "),
        (["denoize", "a.ply"], "there is no command denoize, did you mean denoise?"),
        (["Fair", "a.ply"], "there is no command Fair, did you mean fair?"),
        (["smooth", "a.ply"], "there is no command smooth: say denoise, fair or refine"),
        (["denoise"], "the following arguments are required: INPUT"),
        (["fair", "a.ply", "--what"], "there is no --what (see adaptive-fairing fair --help)"),
        (["fair", "a.ply", "--stepz", "4"], "there is no --stepz, did you mean --steps?"),
        (["denoise", "a.ply", "--outdir=o"], "there is no --outdir, did you mean --out-dir?"),
        (["fair", "a.ply", "--scheme", "tensr"], "there is no 'tensr', did you mean tensor?"),
        (["fair", "a.ply", "--scheme", "x"], "choose from timestep, tensor, uniform"),
        (["fair", "a.ply", "--tau", "much"], "argument --tau: invalid float value: 'much'"),
        (["refine", "a.ply", "--levels", "4"], "argument --levels: invalid choice: 4"),
        (["refine", "a.ply", "--levels", "2", "--limit"], "--limit: not allowed with"),
        (["refine", "a.ply", "b.ply"], "refine takes one INPUT: did you mean -o b.ply?"),
        (["fair", "a.ply", "--quiet", "b.ply"], "b.ply stands apart: name all INPUTs one after"),
        (["fair", "a.ply", "--tau", "1", "--radius", "1"], "both say how far to smooth: give one"),
        (["fair", "a.ply", "--attribute", "Col", "--limit"], "--limit is for the shape"),
        (["fair", "a.ply", "--attribute", "Col", "--keep-volume"], "--keep-volume is for the"),
        (["fair", "a.ply", "--attribute", "Col", "--out-dir", "o"], "for a single mesh"),
        (["fair", "a.txt"], "a.txt: there is no such file or folder"),
        (["fair", "a"], "a: there is no such file or folder"),
        (
            ["fair", __file__],
            "test_arguments.py: unknown kind of file; use one of .blend .obj .ply",
        ),
        (["refine", str(Path(__file__).parent)], "cli is a folder: refine takes a file"),
        (["denoise", "a.ply", "-o", "b.jpg"], "b.jpg: unknown kind of file"),
    ],
)
def test_wrong_arguments_are_status_2(capsys, arguments, message):
    line = error_of(capsys, *arguments)
    assert message in line
    assert re.search(r" \(see adaptive-fairing( (denoise|fair|refine))? --help\)\n$", line)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--radius", "0"], "radius must be a number greater than"),
        (["--max-deviation", "-1"], "max_deviation must be a number greater than"),
        (["--tau", "-1"], "tau must be a number greater than"),
        (["--tau", "nan"], "tau must be a number"),
        (["--steps", "0"], "steps must be a whole number of at least 1, not 0"),
        (["--density-passes", "-1"], "density_passes must be"),
        (["--stop-rate", "0"], "stop_rate must be"),
    ],
)
def test_wrong_values_of_settings_are_status_2(capsys, tmp_path, arguments, message):
    (tmp_path / "a.ply").touch()
    line = error_of(capsys, "fair", tmp_path / "a.ply", *arguments)
    assert message in line
    assert line.endswith(" (see adaptive-fairing fair --help)\n")


@pytest.mark.parametrize("algorithm", ["denoise", "fair"])
@pytest.mark.parametrize(
    ("second", "message"),
    [
        ("out.ply", "out.ply does not exist: did you mean -o out.ply?"),
        ("obj", "obj does not exist: did you mean -o given{ending}.obj?"),
        (".OBJ", ".OBJ does not exist: did you mean -o given{ending}.obj?"),
        ("old.ply", "two INPUTs need a folder for the outputs, --out-dir; or did you mean -o old"),
        ("folder", "give the folder for the outputs with --out-dir"),  # two inputs
        ("given.ply", "give the folder for the outputs with --out-dir"),
        ("*.obj", "give the folder for the outputs with --out-dir"),
    ],
)
def test_a_second_path_that_looks_like_an_output(
    capsys, tmp_path, monkeypatch, algorithm, second, message
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "given.ply").touch()
    (tmp_path / "old.ply").touch()
    (tmp_path / "folder").mkdir()
    line = error_of(capsys, algorithm, "given.ply", second)
    assert message.format(ending=options.ENDINGS[algorithm]) in line


@pytest.mark.parametrize(("algorithm", "word"), [("denoise", "denoised"), ("fair", "faired")])
def test_the_results_of_a_folder_lie_beside_it(tmp_path, monkeypatch, algorithm, word):
    (tmp_path / "scans").mkdir()
    (tmp_path / "scans" / "a.ply").touch()
    output = tmp_path / f"scans_{word}" / "a.ply"
    monkeypatch.chdir(tmp_path)
    for given in ("scans", "scans/", str(tmp_path / "scans")):
        assert [item.output for item in parse([algorithm, given]).plan.items] == [output]
    monkeypatch.chdir(tmp_path / "scans")
    assert [item.output for item in parse([algorithm, "."]).plan.items] == [output]


def test_a_missing_file_is_told_before_blender_is_loaded(capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "bpy", None)
    for algorithm in ("denoise", "fair", "refine"):
        line = error_of(capsys, algorithm, tmp_path / "no.ply", status=1)
        assert line.endswith(f"cannot read {tmp_path / 'no.ply'}: there is no such file\n")
