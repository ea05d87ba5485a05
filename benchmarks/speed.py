"""Speed and memory by size, against the smoothers that people use today.

Every program runs in a process of its own on the same files, in turns: A B C A B C …; the best run
of each counts. So whatever else the machine does hits all alike, and the ratios of one run of this
script hold, whatever the seconds are. Programs that are not installed are left out with a line.

CGAL, libigl and Blender's Laplacian Smooth keep the Laplacian of the first surface in all their
steps. Ours sees the current surface in every step; the row "first matrices" keeps the first ones
too, so that equal work is compared, with scipy's solver as libigl's.

With the folder of an earlier commit our algorithms of then take part too, run by the scripts of
now.

    python -m benchmarks.speed [--sizes 10000 100000 1000000] [--mesh FILE] [--plot speed.png]
        [--earlier FOLDER]
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from adaptive_fairing.core.diffusion.smoothing_radius import equivalent_uniform_tau
from tools.geometry.triangles import edge_lengths

from . import cgal_program, meshes
from .competitors import AGAIN, DENOISE, KEPT, OURS, OWN_RUNS, PART, PRESS, PROGRAMS, SMALL_PRESS
from .measuring import MEGABYTE, Result, load, log_slope, machine, seconds_text, table

ROOT = Path(__file__).resolve().parents[1]

SIZES = [10_000, 30_000, 100_000, 328_000, 1_000_000]

CGAL = "CGAL smooth_shape"
CGAL_AS_NAMED = "CGAL smooth_shape, same parameter"
CGAL_TIMES = {CGAL: 1, CGAL_AS_NAMED: 4}
"""Diffusion time of CGAL's runs over ours: its parameter `time` counts four times as much."""

LIBIGL = "libigl, cotangent + CG"
BLENDER = "Blender Laplacian Smooth"

MODULES = {"Blender": "bpy", "libigl": "igl", "MeshLab": "pymeshlab"}
"""Python module that a program needs, by the first word of its name."""

SETUP_TO_STEP, SETUP_GOAL = "set-up and last measuring / step", 2.0

FOUR = "four steps from scratch"

EARLIER = " at the earlier commit"

RATIOS = (
    ("step / step of CGAL", OURS, "step", CGAL, "step", 0.35),
    (f"{FOUR} / those of CGAL", OURS, "four", CGAL, "four", 0.5),
    (f"processor time of {FOUR} / that of CGAL", OURS, "processor", CGAL, "processor", None),
    ("step / step of CGAL with the same parameter", OURS, "step", CGAL_AS_NAMED, "step", 0.35),
    (
        f"{FOUR} / those of CGAL with the same parameter",
        *(OURS, "four", CGAL_AS_NAMED, "four", 0.5),
    ),
    # From scratch: its further steps keep the first Laplacian, ours see the current surface.
    ("step / step from scratch of libigl with CG", OURS, "step", LIBIGL, "one", 1.0),
    # Its further iterations keep the factorized matrix of the first.
    ("step / one iteration of Blender's Laplacian Smooth", OURS, "step", BLENDER, "one", 0.02),
    (f"{FOUR} with the first matrices / those of {CGAL}", KEPT, "four", CGAL, "four", None),
    (f"{FOUR} with the first matrices / those of {LIBIGL}", KEPT, "four", LIBIGL, "four", None),
    (f"{DENOISE} / {FOUR}", DENOISE, "four", OURS, "four", 3.0),
    *(
        (f"{name}, {kind} / all of it", f"{name}, {kind}", "four", name, "four", goal)
        for name in (OURS, DENOISE)
        for kind, goal in ((AGAIN, None), (PART, 0.12), (PRESS, 0.12), (SMALL_PRESS, None))
    ),
    *(
        (f"{name}, {figure} / earlier", name, figure, name + EARLIER, figure, None)
        for name, figure in ((OURS, "step"), *((name, "four") for name in PROGRAMS))
    ),
)
"""Name, program of ours, its figure, other program, its figure, and what the ratio should be on
meshes of 200,000 triangles and more."""

NOTES = f"""
one step, four: from scratch, with everything that has to be set up; step: one more step, on a
surface that has changed. {OURS}, libigl and CGAL diffuse for the same time; CGAL and
libigl keep the Laplacian of the first surface. CGAL with the same parameter has the number that is
our diffusion time as its own `time`, and so diffuses four times as long, and solves longer.
For the others a step is one iteration of theirs.
{AGAIN}: once more on the same triangles. 1 %, 0.1 %: of the vertices have a weight; mesh known:
after a run on another part of it. {DENOISE} has no steps: one and four are the same run of it.
processor: of all threads together, for the four steps (or the one, where four were not tried).
memory: peak of the whole process, and its growth by the smoothing per triangle.
moved: root mean square displacement after the last step, in mean edges; CGAL keeps the volume."""


def best(runs: list[dict[str, float | None]], has_steps: bool) -> Result:
    """Take the shortest times of several runs, each by itself."""
    one = min(run["one"] for run in runs)
    fours = [run["four"] for run in runs if run["four"] is not None]
    steps = [run["step"] for run in runs if run.get("step") is not None]
    four = min(fours) if fours else None
    step = min(steps, default=None)
    # A smaller difference than this is lost in the noise.
    if has_steps and step is None and four is not None and four > 1.05 * one:
        step = (four - one) / 3
    return Result(
        one=one,
        four=four,
        step=step,
        processor=min(run["processor"] for run in runs),
        moved=runs[-1]["moved"],
        peak=min(run["peak"] for run in runs),
        growth=min(run["peak"] - run["before"] for run in runs),
    )


class Contest:
    """The programs that take part, and how long they have taken so far.

    Parameters
    ----------
    folder : Path
        For the mesh files and CGAL's compiled program.
    wanted : list of str
        Names of the programs.
    earlier : Path, optional
        Folder of an earlier commit: its algorithms take part, too.
    patience : float
        Seconds that a program may take for a step. One that is expected to take longer, as time
        grows with the power 1.5 of the size, is left out; one step is then all that is tried.
    """

    def __init__(
        self, folder: Path, wanted: list[str], earlier: Path | None, patience: float
    ) -> None:
        self._folder = folder
        self._roots: dict[str, Path] = {}
        self._patience = patience
        self._commands: dict[str, list[str]] = {}
        self._last: dict[str, tuple[int, float]] = {}
        for name in wanted:
            module = MODULES.get(name.split()[0].rstrip(","))
            if name in CGAL_TIMES:
                try:
                    self._commands[name] = [str(cgal_program.compiled(folder))]
                except cgal_program.NotInstalledError as error:
                    print(f"{name}: left out, {error}")
            elif module is not None and importlib.util.find_spec(module) is None:
                print(f"{name}: left out, needs the Python module {module}")
            else:
                self._commands[name] = [sys.executable, "-m", "benchmarks.competitors", name]
                if earlier is not None and name.split(",")[0] in (OURS, DENOISE):
                    then = name + EARLIER
                    self._commands[then] = self._commands[name]
                    self._roots[then] = _with_core_of(earlier, folder)

    def run(self, mesh: meshes.Mesh, radius: float, repeats: int) -> dict[str, Result]:
        """Let all programs smooth a mesh in turns; results by name, in the order of the table."""
        settings = meshes.comparable_settings(mesh, radius)
        time = equivalent_uniform_tau(mesh.vertices, mesh.triangles, settings)
        path = self._folder / "mesh.ply"
        mesh.write(path)
        runs: dict[str, list[dict[str, float | None]]] = {}
        for turn in range(repeats):
            for name in self._commands:
                if self._is_too_slow(name, len(mesh.triangles), turn, bool(runs.get(name))):
                    continue
                run = self._one_run(name, path, settings.tau, time)
                if run is not None:
                    runs.setdefault(name, []).append(run)
                    self._last[name] = len(mesh.triangles), run["one"]
        path.unlink()
        return {
            name: best(runs[name], not name.startswith(DENOISE))
            for name in self._commands
            if name in runs
        }

    def _is_too_slow(self, name: str, n_triangles: int, turn: int, has_run: bool) -> bool:
        if name not in self._last:
            return turn > 0 and not has_run  # it failed
        size, seconds = self._last[name]
        if has_run:
            return seconds > self._patience / 4  # one look at a slow program is enough
        expected = seconds * (n_triangles / size) ** 1.5
        if turn == 0 and expected > self._patience:
            print(f"{name}: left out at {n_triangles} triangles, would take {expected:.0f} s")
        return expected > self._patience

    def _one_run(
        self, name: str, path: Path, tau: float, time: float
    ) -> dict[str, float | None] | None:
        command = [*self._commands[name], str(path)]
        four_up_to = self._patience / 4
        if name in CGAL_TIMES:
            command += [repr(CGAL_TIMES[name] * time), repr(four_up_to)]
        else:
            command += ["--tau", repr(tau), "--time", repr(time), "--patience", repr(four_up_to)]
        try:
            done = subprocess.run(
                command,
                capture_output=True,
                text=True,
                timeout=5 * self._patience,
                check=True,
                cwd=self._roots.get(name, ROOT),
            )
        except subprocess.TimeoutExpired:
            print(f"{name}: given up after {5 * self._patience:.0f} s")
            return None
        except subprocess.CalledProcessError as error:
            reason = (error.stderr.strip().splitlines() or ["no message"])[-1]
            print(f"{name}: failed with status {error.returncode}: {reason}")
            return None
        # Blender may write lines of its own first, and when it ends.
        line = next(line for line in done.stdout.splitlines() if line.startswith('{"one"'))
        return json.loads(line)


def _with_core_of(earlier: Path, folder: Path) -> Path:
    """Make a folder with the package of an earlier commit and the benchmarks of now."""
    root = folder / "earlier"
    if not root.exists():
        root.mkdir()
        for name in ("benchmarks", "tools"):
            (root / name).symlink_to(ROOT / name)
        (root / "adaptive_fairing").symlink_to(earlier.resolve() / "adaptive_fairing")
    return root


def print_results(mesh: meshes.Mesh, results: dict[str, Result]) -> None:
    """Print the table of one mesh."""
    edge = edge_lengths(mesh.vertices, mesh.triangles).mean()
    n = len(mesh.triangles)
    rows = [
        [
            name,
            seconds_text(result.one),
            seconds_text(result.four),
            seconds_text(result.step),
            seconds_text(result.processor),
            f"{result.peak / MEGABYTE:.0f} MB",
            f"{result.growth / n:.0f} B",
            f"{result.moved / edge:.2f}",
        ]
        for name, result in results.items()
    ]
    classes = meshes.count_classes(mesh)
    print(f"\n## {mesh.name}, {n} triangles of {classes} classes (load {load()})\n")
    times = ["one step s", "four s", "step s", "processor s"]
    print(table(["", *times, "memory", "per triangle", "moved"], rows))
    print()
    goals = {SETUP_TO_STEP: SETUP_GOAL} | {name: goal for name, *_, goal in RATIOS}
    for name, ratio in ratios_of(results).items():
        goal = goals.get(name)
        print(f"{name}: {ratio:.3g}" + (f" (goal: at most {goal:g})" if goal else ""), flush=True)


def ratios_of(results: dict[str, Result]) -> dict[str, float]:
    """Ratios of one mesh; less is better."""
    ratios = {}
    ours = results.get(OURS)
    if ours is not None and ours.four and ours.step:
        ratios[SETUP_TO_STEP] = (ours.four - 4 * ours.step) / ours.step
    for name, program, figure, other, other_figure, _ in RATIOS:
        own, theirs = (
            getattr(results.get(each), which, None)
            for each, which in ((program, figure), (other, other_figure))
        )
        if own and theirs:
            ratios[name] = own / theirs
    return ratios


def print_slopes(sizes: dict[str, list[tuple[int, dict[str, Result]]]]) -> None:
    """Print how cost grows with size on each kind of mesh."""
    kinds = ("one", "step", "growth")
    for shape, series in sizes.items():
        if len(series) < 2:
            continue
        rows = []
        for name in dict.fromkeys(name for _, results in series for name in results):
            points = [(n, results[name]) for n, results in series if name in results]
            slopes = {}
            for kind in kinds:
                known = [(n, getattr(result, kind)) for n, result in points]
                known = [(n, cost) for n, cost in known if cost]
                if len(known) > 1:
                    slopes[kind] = log_slope(*zip(*known, strict=True))
            rows.append([name, *(f"{slopes[k]:.2f}" if k in slopes else "–" for k in kinds)])
        print(f"\n## {shape}: cost grows with the power … of the number of triangles\n")
        print(table(["", "one step", "step", "memory"], rows))


def _like_others(results: dict[str, Result]) -> dict[str, Result]:
    """Results of what every program does: smoothing all of a mesh from scratch."""
    others = OWN_RUNS.keys() - {OURS}
    return {
        name: result
        for name, result in results.items()
        if name not in others and not name.endswith(EARLIER)
    }


def main() -> None:
    """Run the contest on every mesh asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    meshes.add_arguments(parser, sizes=SIZES)
    parser.add_argument("--repeats", type=int, default=3, help="runs of each program")
    parser.add_argument("--patience", type=float, default=160, help="seconds for a step, at most")
    parser.add_argument("--programs", nargs="*", default=[*PROGRAMS, *CGAL_TIMES], metavar="NAME")
    parser.add_argument("--earlier", type=Path, help="folder of an earlier commit")
    parser.add_argument("--plot", type=Path, default=Path("speed.png"), help="picture to write")
    arguments = parser.parse_args()
    print(machine())
    sizes: dict[str, list[tuple[int, dict[str, Result]]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        contest = Contest(Path(folder), arguments.programs, arguments.earlier, arguments.patience)
        for mesh in meshes.chosen(arguments):
            results = contest.run(mesh, arguments.radius, arguments.repeats)
            print_results(mesh, results)
            sizes.setdefault(mesh.name, []).append((len(mesh.triangles), results))
    print(NOTES)
    print_slopes(sizes)
    if any(len(series) > 1 for series in sizes.values()):
        from .speed_plot import draw  # matplotlib is wanted for this alone

        drawn = {
            shape: [(n, _like_others(results)) for n, results in series]
            for shape, series in sizes.items()
            if len(series) > 1
        }
        draw(drawn, arguments.plot)
        print(f"\ndrawn in {arguments.plot}")


if __name__ == "__main__":
    main()
