"""The program as a process: ``python -m adaptive_fairing`` and the command ``adaptive-fairing``."""

import atexit
import os
import sys

from .cli.main import COULD_NOT, main


def run() -> None:
    """Run the command line and end the process with its status.

    Blender 4.2 as a Python module crashes while the interpreter is taken down, if it has exported
    glTF: the result is complete, but the status of the process says otherwise. So the process ends
    before that, after all that was to be done at exit, Blender's own cleaning up included.
    """
    status = COULD_NOT

    def leave() -> None:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status)

    atexit.register(leave)  # registered first, called last
    status = main()


if __name__ == "__main__":
    run()
