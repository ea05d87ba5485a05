#!/usr/bin/env python3
"""Set up a real Blender program in a Debian chroot, and run it.

The ``bpy`` wheels have no window, no command line and no modal operators, so some tests need the
real program. Debian packages it with its own Python, numpy and scipy. This script installs it once
into a directory of its own and reuses it afterwards::

    sudo tools/real_blender.py setup
    sudo tools/real_blender.py run -- -b --version
    sudo tools/real_blender.py run --bind ~/scans -- -b --python look.py

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
    SetupError,
    locate,
    require_debian_root,
    run_inside,
    set_up,
)


def blender_script(arguments: Sequence[str], *, screen: tuple[int, int] | None = None) -> str:
    """Shell script that runs Blender, in a window that fills a virtual screen if asked for.

    Parameters
    ----------
    arguments : sequence of str
        Blender's arguments.
    screen : (int, int), optional
        Width and height of the virtual screen in pixels. Without it there is no screen.
    """
    if screen is None:
        return shlex.join(["blender", *arguments])
    width, height = screen
    window = ["--gpu-backend", "opengl", "--window-geometry", "0", "0", str(width), str(height)]
    lines = [
        f"Xvfb :0 -screen 0 {width}x{height}x24 -nolisten tcp 2>/tmp/xvfb.log &",
        "while ! xdpyinfo >/dev/null 2>&1; do kill -0 $! || exit 1; sleep 0.1; done",
    ]
    return "\n".join([*lines, shlex.join(["blender", *window, *arguments])])


def environment_setting(text: str) -> tuple[str, str]:
    """Name and value from ``NAME=VALUE``."""
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise ValueError(text)
    return name, value


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; returns the exit code of what ran inside."""
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
    run = commands.add_parser("run", help="run Blender in the chroot")
    run.add_argument(
        "--bind", type=Path, action="append", default=[], help="directory to show inside"
    )
    run.add_argument(
        "--env", type=environment_setting, action="append", default=[], metavar="NAME=VALUE"
    )
    run.add_argument("rest", nargs="*", metavar="-- ARGUMENTS")
    options = parser.parse_args(arguments)
    chroot = locate(options.suite, options.cache)
    try:
        set_up(chroot)
        if options.command == "setup":
            print(f"Blender is ready in {chroot.root}")
            return 0
        require_debian_root()
        return run_inside(
            chroot,
            blender_script(options.rest),
            binds=[path.expanduser().resolve() for path in options.bind],
            environment=dict(options.env),
        )
    except SetupError as error:
        print(f"real_blender: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
