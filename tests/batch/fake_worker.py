"""A worker process without Blender: what it does is written in the name of its object.

    needs=3,takes=0.1,fails=no good      needs 3 GB, works for 0.1 s, fails
    dies=9                               ends itself by this signal
    holds=0.3                            takes 0.3 GB without having said so

Everything it does is appended to the file that the environment variable FAKE_LOG names.
"""

import json
import os
import sys
import time

from adaptive_fairing.batch.memory_use import peak_bytes
from adaptive_fairing.batch.messages import Job, decode, encode


def log(**entry):
    entry["process"] = os.getpid()
    with open(os.environ["FAKE_LOG"], "a") as stream:
        stream.write(json.dumps(entry) + "\n")


def send(**message):
    sys.stdout.write("Blender was here" + encode(message))
    sys.stdout.flush()


def messages():
    for line in sys.stdin:
        message = decode(line)
        if message is not None:
            yield message


inbox = messages()
for message in inbox:
    job = Job.of(message)
    wishes = dict(word.partition("=")[::2] for word in job.object_name.split(",") if word)
    if "dies" in wishes:
        sys.stderr.write("something terrible\n\n")
        sys.stderr.flush()
        os.kill(os.getpid(), int(wishes["dies"]))
    if "needs" in wishes:
        send(event="needs", bytes=int(float(wishes["needs"]) * 1e9))
        if next(inbox)["answer"] == "later":
            log(what="aside", output=job.output)
            send(event="later")
            continue
    log(what="start", output=job.output, needs=wishes.get("needs"))
    held = b"x" * int(float(wishes.get("holds", 0)) * 1e9)
    time.sleep(float(wishes.get("takes", 0)))
    log(what="end", output=job.output, needs=wishes.get("needs"))
    if "fails" in wishes:
        send(event="failed", error=wishes["fails"])
    else:
        peak = {"peak_bytes": peak_bytes()} if "holds" in wishes else {}
        send(event="done", report={"of": job.output}, **peak)
    del held
log(what="leave", output=None)
