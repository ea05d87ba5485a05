"""The program as a process: ``python -m adaptive_fairing`` and the command ``adaptive-fairing``."""

import atexit
import contextlib
import os
import sys
import warnings

from .cli.interrupts import leave_at_interrupt


def run() -> None:
    """Run the command line and end the process with its status.

    Blender 4.2 as a Python module crashes while the interpreter is taken down, if it has exported
    glTF: the result is complete, but the status of the process says otherwise. So the process ends
    before that, after all that was to be done at exit, Blender's own cleaning up included.
    """
    leave_at_interrupt()  # before anything that takes time

    from .cli.apart import prepare_standard_streams
    from .cli.main import main
    from .cli.status import COULD_NOT

    status = COULD_NOT

    def leave() -> None:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError):  # nobody listens any more
                stream.flush()
        os._exit(status)

    atexit.register(leave)  # registered first, called last
    prepare_standard_streams()
    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # of libraries: messages are for users
    status = main(is_apart=True)


if __name__ == "__main__":
    run()
