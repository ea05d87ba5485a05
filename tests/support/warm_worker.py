"""A worker process that stays when its batch ends, so that Blender starts once for many batches.

What a batch starts is a relay between its pipes and that process: messages, settings, files and the
claims of memory go their usual ways. It serves one batch after the other, each by a worker of its
own; batches with several worker processes need the real ones.
"""

import atexit
import os
import socket
import subprocess
import sys
import threading
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

RELAY = """
import os, socket, sys, threading
with socket.create_connection(("127.0.0.1", int(sys.argv[1]))) as worker:
    worker.sendall(os.fsencode(os.getcwd()) + b"\\n")
    def pass_on():
        while piece := os.read(0, 65536):
            worker.sendall(piece)
        worker.shutdown(socket.SHUT_WR)
    threading.Thread(target=pass_on, daemon=True).start()
    while piece := worker.recv(65536):
        sys.stdout.buffer.write(piece)
        sys.stdout.buffer.flush()
"""


def worker_command():
    """Return the command by which a batch starts its only worker."""
    if _started()[0].poll() is not None:  # it has crashed, in a test that says so
        _started.cache_clear()
    return [sys.executable, "-S", "-c", RELAY, str(_started()[1])]


@cache
def _started():
    """Start the process; return it, and the port at which it waits for relays."""
    process = subprocess.Popen(
        [sys.executable, __file__], cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    atexit.register(process.communicate)  # which ends it
    return process, int(process.stdout.readline())


def _serve():
    # Blender 5.2 prints when it is imported, and nobody reads what it prints later.
    told = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    from adaptive_fairing.blender.jobs import batch_worker
    from adaptive_fairing.cli import main as cli

    class Stays:
        """In place of the module os: a worker whose batch has ended leaves at once by it."""

        @staticmethod
        def _exit(status):
            """Do nothing: it leaves after its job."""

    batch_worker.os = Stays
    listener = socket.create_server(("127.0.0.1", 0))
    told.write(f"{listener.getsockname()[1]}\n")
    told.close()
    threading.Thread(target=_follow_parent, daemon=True).start()
    while True:
        batch, _ = listener.accept()
        requests, answers = batch.makefile("rb"), batch.makefile("w", encoding="utf-8")
        os.chdir(os.fsdecode(requests.readline()[:-1]))
        sys.stdin, sys.stdout = (line.decode() for line in requests), answers
        cli.main(["--worker"])
        for each in (requests, answers, batch):
            each.close()


def _follow_parent():
    os.read(0, 1)
    os._exit(0)


if __name__ == "__main__":
    sys.path[0] = str(ROOT)
    try:
        _serve()
    finally:
        sys.excepthook(*sys.exc_info())
        os._exit(1)  # at once: a thread still waits for requests
