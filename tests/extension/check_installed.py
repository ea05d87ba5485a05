"""Check an installed extension from inside Blender, as the user's Blender would run it.

Runs as a program in a process of its own, under the bpy module or under a real Blender, with
nothing but the standard library, bpy and numpy::

    python check_installed.py PHASE --work DIR --result FILE [--zip ZIP]
    blender -b --factory-startup --python check_installed.py -- PHASE ...

The environment variable BLENDER_USER_RESOURCES names the user directory. Phases, each a fresh start
of Blender:

install        install the zip from file and enable it
use            enable, run operator and command, disable, enable again, run, uninstall
without-scipy  install and enable where scipy cannot be imported; say so, and uninstall

The result is JSON: what this Blender is, and each check with what was seen. The first check that
fails ends the phase; the exit status is 0 if none did.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import os
import runpy
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

REPOSITORY = "user_default"
EXTENSION = "adaptive_fairing"
MODULE = f"bl_ext.{REPOSITORY}.{EXTENSION}"
STEPS = 2
EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "fair_blend_file.py"


def noisy_sphere() -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Return a closed sphere of quads with triangles at two poles of valence 16, with noise.

    Vertices are (n, 3) float32; the noise is the fixed one of a seeded generator.
    """
    rings, segments = 9, 16
    polar = np.linspace(0.0, math.pi, rings + 2)[1:-1, None]
    around = np.linspace(0.0, 2.0 * math.pi, segments, endpoint=False)[None, :]
    belt = np.stack(
        [
            np.sin(polar) * np.cos(around),
            np.sin(polar) * np.sin(around),
            np.cos(polar) * np.ones_like(around),
        ],
        axis=-1,
    ).reshape(-1, 3)
    vertices = np.concatenate([belt, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    vertices *= 1.0 + 0.03 * np.random.default_rng(3).standard_normal((len(vertices), 1))
    north, south = len(belt), len(belt) + 1
    last = (rings - 1) * segments
    faces: list[tuple[int, ...]] = []
    for here in range(segments):
        after = (here + 1) % segments
        faces.append((north, here, after))
        faces.append((south, last + after, last + here))
        for ring in range(0, last, segments):
            below = ring + segments
            faces.append((ring + here, below + here, below + after, ring + after))
    return vertices.astype(np.float32), faces


def write_ply(path: Path) -> None:
    """Write `noisy_sphere` as an ASCII PLY whose numbers give the float32 values back exactly."""
    vertices, faces = noisy_sphere()
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {len(faces)}", "property list uchar uint vertex_indices", "end_header"]
    lines += [" ".join(f"{value:.9g}" for value in vertex) for vertex in vertices.tolist()]
    lines += [" ".join(map(str, (len(face), *face))) for face in faces]
    path.write_text("\n".join(lines) + "\n", "ascii")


def main() -> int:
    """Run one phase, write its result and return the exit status."""
    parser = argparse.ArgumentParser(description="Check the installed extension.")
    parser.add_argument("phase", choices=PHASES)
    parser.add_argument("--work", type=Path, required=True, help="folder for meshes")
    parser.add_argument("--result", type=Path, required=True, help="JSON file to write")
    parser.add_argument("--zip", type=Path, help="the package to install")
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    options = parser.parse_args(given)

    write_ply(options.work / "noisy.ply")
    result = {
        "blender": bpy.app.version_string,
        "python": ".".join(map(str, sys.version_info[:3])),
        "numpy": np.__version__,
        "checks": {},
        "failed": None,
    }
    for check in PHASES[options.phase]:
        name = check.__name__.removeprefix("check_").replace("_", " ")
        try:
            result["checks"][name] = check(options)
        except Exception:  # whatever it is, it is this check's finding
            result["failed"] = {"check": name, "error": traceback.format_exc()}
            break
    options.result.write_text(json.dumps(result, indent=2), "utf-8")
    return 1 if result["failed"] else 0


# --- The checks: each returns what it saw, in a few words -----------------------------------------


def check_install(options: argparse.Namespace) -> str:
    """Install from file, as "Install from Disk" does."""
    started = time.perf_counter()
    status = bpy.ops.extensions.package_install_files(
        filepath=str(options.zip), repo=REPOSITORY, enable_on_install=False, overwrite=True
    )
    assert status == {"FINISHED"}, status
    assert (_user_directory() / "extensions" / REPOSITORY / EXTENSION / "__init__.py").is_file()
    return f"{time.perf_counter() - started:.2f} s"


def check_first_enable(options: argparse.Namespace) -> str:
    """Enable for the first time: Blender unpacks the wheels."""
    started = time.perf_counter()
    _enable()
    return f"{time.perf_counter() - started:.2f} s"


def check_cold_enable(options: argparse.Namespace) -> str:
    """Enable in a fresh Blender: what every later start costs. scipy must wait until it is used."""
    options.footprint = _footprint()
    before = set(sys.modules)
    started = time.perf_counter()
    _enable()
    elapsed = time.perf_counter() - started
    new = set(sys.modules) - before
    heavy = sorted(name for name in new if name.partition(".")[0] in {"scipy", "tqdm"})
    assert not heavy, f"imported on enabling: {heavy[:5]}"
    assert _footprint() != options.footprint, "enabling registered nothing"
    own = sum(name.startswith(MODULE) for name in new)
    return f"{elapsed * 1000:.0f} ms, {own} modules"


def check_operator(options: argparse.Namespace) -> str:
    """Fair a mesh with the operator and look at its shape keys."""
    options.positions = _run_operator()
    import scipy

    return f"scipy {scipy.__version__}"


def check_scipy_origin(options: argparse.Namespace) -> str:
    """Tell whose scipy it was: the extension's wheel or the Blender's own."""
    import scipy

    origin = Path(scipy.__file__).resolve()
    bundled = _user_directory() / "extensions" / ".local"
    carries_wheels = any((_extension_directory() / "wheels").glob("scipy-*.whl"))
    assert origin.is_relative_to(bundled) == carries_wheels, origin
    return "wheel" if carries_wheels else "own"


def check_command(options: argparse.Namespace) -> str:
    """Run the registered command's function: output, and the exit codes 0, 1 and 2."""
    command = importlib.import_module(f"{MODULE}.{EXTENSION}.blender.command")
    source, output = options.work / "noisy.ply", options.work / "command.ply"
    settings = ["--steps", str(STEPS)]
    status = command.run(["fair", str(source), "-o", str(output), *settings, "--quiet"])
    assert status == 0, f"exit code {status} for a good mesh"
    assert output.stat().st_size > 0
    status = command.run(["fair", str(options.work / "missing.ply"), "-o", str(output), "--quiet"])
    assert status == 1, f"exit code {status} for a missing file"
    status = command.run(["fair", "--no-such-option"])
    assert status == 2, f"exit code {status} for a wrong argument"
    return "0 1 2"


def check_disable(options: argparse.Namespace) -> str:
    """Disable: every class, property, handler and menu entry is gone."""
    status = bpy.ops.preferences.addon_disable(module=MODULE)
    assert status == {"FINISHED"}, status
    after = _footprint()
    left = {key: after[key] ^ options.footprint[key] for key in after}
    left = {key: sorted(value) for key, value in left.items() if value}
    assert not left, f"left registered: {left}"
    return "clean"


def check_enable_again(options: argparse.Namespace) -> str:
    """Enable in the same Blender once more; the operator gives the same positions."""
    _enable()
    again = _run_operator()
    assert np.array_equal(again, options.positions), "other positions than before"
    return "same positions"


def check_example_script(options: argparse.Namespace) -> str:
    """Run examples/fair_blend_file.py on an opened file with two meshes and a camera."""
    opened, saved = options.work / "opened.blend", options.work / "saved.blend"
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    for place in (0.0, 3.0):
        _add_sphere().location.x = place
    bpy.ops.wm.save_as_mainfile(filepath=str(opened))
    before = sys.argv
    sys.argv = ["blender", "-b", str(opened), "--python", str(EXAMPLE), "--", str(saved)]
    try:
        runpy.run_path(str(EXAMPLE), run_name="__main__")
    finally:
        sys.argv = before
    bpy.ops.wm.open_mainfile(filepath=str(saved))
    keys = [thing.data.shape_keys for thing in bpy.data.objects if thing.name.startswith("Sphere")]
    assert [len(each.key_blocks) for each in keys] == [5, 5]
    return "2 meshes"


def check_uninstall(options: argparse.Namespace) -> str:
    """Uninstall: nothing of the extension is left in the user directory."""
    names = [repository.module for repository in bpy.context.preferences.extensions.repos]
    status = bpy.ops.extensions.package_uninstall(
        repo_index=names.index(REPOSITORY), pkg_id=EXTENSION
    )
    assert status == {"FINISHED"}, status
    assert not hasattr(bpy.types, "OBJECT_OT_adaptive_fairing")
    files = [path.relative_to(_user_directory()) for path in _user_directory().rglob("*")]
    left = [str(path) for path in files if EXTENSION in str(path) or "scipy" in str(path)]
    assert not left, f"left in the user directory: {left[:5]}"
    return "clean"


def check_no_scipy(options: argparse.Namespace) -> str:
    """Make sure that scipy cannot be imported, whatever is installed."""
    sys.modules["scipy"] = None  # the import system's own way of saying "not there"
    try:
        importlib.import_module("scipy.sparse")
    except ImportError:
        return "absent"
    raise AssertionError("scipy could be imported")


def check_message(options: argparse.Namespace) -> str:
    """Without scipy the operator and the command say in one line what is missing."""
    try:
        _run_operator()
    except RuntimeError as error:
        message = str(error).strip()
    else:
        raise AssertionError("the operator ran without scipy")
    assert "scipy" in message, message
    # In this process: another one, which the command would start, could have a scipy of its own.
    program = importlib.import_module(f"{MODULE}.{EXTENSION}.cli.main")
    given, output = options.work / "noisy.ply", options.work / "none.ply"
    status = program.main(["fair", str(given), "-o", str(output)])
    assert status == 1, f"exit code {status}"
    return message.splitlines()[0]


# --- What the checks share ------------------------------------------------------------------------


def _user_directory() -> Path:
    return Path(os.environ["BLENDER_USER_RESOURCES"]).resolve()


def _extension_directory() -> Path:
    return _user_directory() / "extensions" / REPOSITORY / EXTENSION


def _enable() -> None:
    status = bpy.ops.preferences.addon_enable(module=MODULE)
    assert status == {"FINISHED"}, status
    assert MODULE in bpy.context.preferences.addons, "Blender did not enable the extension"


def _add_sphere() -> bpy.types.Object:
    vertices, faces = noisy_sphere()
    mesh = bpy.data.meshes.new("Sphere")
    mesh.from_pydata(vertices.tolist(), [], faces)
    sphere = bpy.data.objects.new("Sphere", mesh)
    bpy.context.collection.objects.link(sphere)
    return sphere


def _run_operator() -> np.ndarray:
    """Fair a fresh copy of the sphere; return the last shape key's positions, (n, 3) float32."""
    sphere = _add_sphere()
    bpy.ops.object.select_all(action="DESELECT")
    sphere.select_set(True)
    bpy.context.view_layer.objects.active = sphere
    status = bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=STEPS)
    assert status == {"FINISHED"}, status
    vertices, _ = noisy_sphere()
    keys = sphere.data.shape_keys.key_blocks
    assert keys.keys() == ["Basis", *(f"Fairing {index + 1}" for index in range(STEPS))]
    positions = np.empty(3 * len(vertices), np.float32)
    keys[-1].data.foreach_get("co", positions)
    assert np.isfinite(positions).all()
    assert not np.array_equal(positions, vertices.ravel()), "nothing moved"
    return positions.reshape(-1, 3)


def _footprint() -> dict[str, set[str]]:
    """Return everything an add-on registers and must take back.

    A menu that was once extended lists Blender's own entry too, for good; that one is left out.
    """
    owners = (bpy.types.Scene, bpy.types.Object, bpy.types.Mesh, bpy.types.WindowManager)
    handlers = bpy.app.handlers
    lists = {name: getattr(handlers, name) for name in dir(handlers) if not name.startswith("_")}
    drawn = ((name, getattr(getattr(bpy.types, name), "draw", None)) for name in dir(bpy.types))
    return {
        "classes": set(dir(bpy.types)),
        "properties": {f"{o.__name__}.{key}" for o in owners for key in o.bl_rna.properties.keys()},
        "handlers": {
            f"{name}: {getattr(item, '__name__', item)}"
            for name, items in lists.items()
            if isinstance(items, list)
            for item in items
        },
        "menus": {
            f"{name}: {function.__module__}.{function.__name__}"
            for name, draw in drawn
            for function in getattr(draw, "_draw_funcs", ())
            if not function.__module__.startswith("bl_ui.")
        },
    }


PHASES: dict[str, tuple[Callable[[argparse.Namespace], str], ...]] = {
    "install": (check_install, check_first_enable),
    "use": (
        check_cold_enable,
        check_operator,
        check_scipy_origin,
        check_command,
        check_disable,
        check_enable_again,
        check_example_script,
        check_uninstall,
    ),
    "without-scipy": (
        check_no_scipy,
        check_install,
        check_cold_enable,
        check_message,
        check_disable,
        check_uninstall,
    ),
}

if __name__ == "__main__":
    exit_status = main()
    if bpy.app.module:
        # Taken down by the interpreter, the bpy modules of some Blenders crash or wait for ever.
        os._exit(exit_status)
    sys.exit(exit_status)
