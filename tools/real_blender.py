#!/usr/bin/env python3
"""Set up a real Blender program in a Debian chroot, and run it with or without a window.

The ``bpy`` wheels have no window, no command line and no modal operators, so some tests need the
real program. Debian packages it with its own Python, numpy and scipy. This script installs it once
into a directory of its own and reuses it afterwards::

    sudo tools/real_blender.py setup
    sudo tools/real_blender.py run -- -b --version
    sudo tools/real_blender.py run --window --bind ~/scans -- --python look.py
    sudo tools/real_blender.py run --window --shots /tmp/shots --every 5 -- scan.blend
    sudo tools/real_blender.py shell -- xdotool version

What a run starts ends with it, it has no network, and its home directory is empty at the start, see
debian_chroot.py. The project is visible inside at its usual path, and so is every ``--bind``
directory.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from debian_chroot import (
    CACHE_VARIABLE,
    Chroot,
    SetupError,
    locate,
    require_debian_root,
    run_inside,
    set_up,
)


def blender_script(
    arguments: Sequence[str],
    *,
    screen: tuple[int, int] | None = None,
    shots: Path | None = None,
    every: float = 5.0,
) -> str:
    """Shell script that runs Blender, in a window that fills a virtual screen if asked for.

    Parameters
    ----------
    arguments : sequence of str
        Blender's arguments.
    screen : (int, int), optional
        Width and height of the virtual screen in pixels. Without it there is no screen.
    shots : Path, optional
        Directory for pictures ``0001.png`` ... of the whole screen.
    every : float
        Seconds between two pictures.
    """
    if screen is None:
        return shlex.join(["blender", *arguments])
    width, height = screen
    window = ["--gpu-backend", "opengl", "--window-geometry", "0", "0", str(width), str(height)]
    lines = [
        f"Xvfb :0 -screen 0 {width}x{height}x24 -nolisten tcp 2>/tmp/xvfb.log &",
        "while ! xdpyinfo >/dev/null 2>&1; do kill -0 $! || exit 1; sleep 0.1; done",
    ]
    if shots is not None:
        picture = f'"$(printf %s/%04d.png {shlex.quote(str(shots))} $number)"'
        lines += [
            "number=0",
            f"while sleep {every}; do number=$((number + 1)); "
            f"import -silent -window root {picture}; done &",
        ]
    return "\n".join([*lines, shlex.join(["blender", *window, *arguments])])


def run_blender(
    chroot: Chroot,
    arguments: Sequence[str],
    *,
    screen: tuple[int, int] | None = None,
    shots: Path | None = None,
    every: float = 5.0,
    binds: Sequence[Path] = (),
    environment: dict[str, str] | None = None,
    timeout: float | None = None,
) -> int:
    """Run Blender in the chroot, with the parameters of `run_inside`; return its exit code."""
    return run_inside(
        chroot,
        blender_script(arguments, screen=screen, shots=shots, every=every),
        binds=binds if shots is None else (*binds, shots),
        environment=environment,
        timeout=timeout,
    )


def screen_size(text: str) -> tuple[int, int]:
    """Width and height from a text such as ``1600x1000``."""
    width, _, height = text.partition("x")
    return int(width), int(height)


def environment_setting(text: str) -> tuple[str, str]:
    """Name and value from ``NAME=VALUE``."""
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise ValueError(text)
    return name, value


def parse_arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--suite", default="trixie", help="Debian release: trixie has Blender 4.3.2 (default), sid"
    )
    parser.add_argument(
        "--cache",
        type=Path,
        help=f"directory of the chroot (default: ${CACHE_VARIABLE}, "
        "else ~/.cache/adaptive-fairing/real-blender/SUITE)",
    )
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("setup", help="install Blender in the chroot, if it is not there yet")

    inside = argparse.ArgumentParser(add_help=False)
    inside.add_argument(
        "--bind", type=Path, action="append", default=[], help="directory to show inside"
    )
    inside.add_argument(
        "--env", type=environment_setting, action="append", default=[], metavar="NAME=VALUE"
    )
    inside.add_argument("--timeout", type=float, help="seconds after which to end everything")
    run = commands.add_parser("run", parents=[inside], help="run Blender in the chroot")
    run.add_argument("--window", action="store_true", help="with a window on a virtual screen")
    run.add_argument("--screen", type=screen_size, default=(1600, 1000), metavar="WIDTHxHEIGHT")
    run.add_argument("--shots", type=Path, help="with --window: directory for screen pictures")
    run.add_argument("--every", type=float, default=5.0, help="seconds between pictures")
    shell = commands.add_parser("shell", parents=[inside], help="run any command in the chroot")
    for command in (run, shell):
        command.add_argument("rest", nargs="*", metavar="-- ARGUMENTS")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; returns the exit code of what ran inside."""
    options = parse_arguments(arguments)
    chroot = locate(options.suite, options.cache)
    try:
        set_up(chroot)
        if options.command == "setup":
            print(f"Blender is ready in {chroot.root}")
            return 0
        require_debian_root()
        inside = {
            "binds": [path.expanduser().resolve() for path in options.bind],
            "environment": dict(options.env),
            "timeout": options.timeout,
        }
        if options.command == "shell":
            return run_inside(chroot, shlex.join(options.rest), **inside)
        shots = options.shots and options.shots.expanduser().resolve()
        if shots:
            shots.mkdir(parents=True, exist_ok=True)
        screen = options.screen if options.window else None
        return run_blender(
            chroot, options.rest, screen=screen, shots=shots, every=options.every, **inside
        )
    except SetupError as error:
        print(f"real_blender: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
