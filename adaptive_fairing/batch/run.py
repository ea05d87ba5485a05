"""Run of a batch: skip finished meshes, hand out the others, write records and the summary."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from ..core import DenoiseSettings, FairingSettings
from ..files.report import settings_record
from ..version import program_version
from .conflicts import identity
from .messages import Job
from .plan import Item
from .records import has_failed, input_stamp, is_finished, read_record, write_record
from .schedule import Outcome, Schedule, Task, first_claim
from .summary import DONE, FAILED, MISSING, SKIPPED, mesh_entry, summary

Json = dict[str, Any]


class Reporter(Protocol):
    """Receiver of the progress of a batch."""

    def finished(self, entry: Json) -> None:
        """Count a mesh that needs no more work; its entry is that of `mesh_entry`."""


@dataclass(frozen=True)
class Batch:
    """A batch to run.

    Attributes
    ----------
    items
        Meshes of this run.
    settings
        Settings of the algorithm.
    object_name
        Mesh object of every input; None if each holds a single one.
    reference
        First frame of the whole sequence, if the meshes are its frames; None otherwise.
    same_strength
        Whether all frames are smoothed as strongly as the reference.
    command
        Command that starts a worker process.
    jobs
        Number of worker processes.
    refine
        As in `FairingJob`.
    memory
        Bytes that the worker processes may hold together; None for no limit.
    """

    items: Sequence[Item]
    settings: DenoiseSettings | FairingSettings
    object_name: str | None = None
    reference: Item | None = None
    same_strength: bool = False
    refine: int | None = None
    command: Sequence[str] = field(default=())
    jobs: int = 1
    memory: int | None = None

    def made_with(self, item: Item) -> Json:
        """Everything an output depends on; a finished output is compared by it."""
        known = {
            "version": program_version(),
            **settings_record(self.settings),
            "object": self.object_name,
            # If the result replaces its input, nothing is left to compare with.
            "input_files": None if _replaces_input(item) else input_stamp(item.input),
            "frame": item.frame,
            "output": item.name,
        }
        if self.refine is not None:
            known["refine"] = self.refine
        if self.reference is not None:
            known["sequence"] = {
                "reference_files": input_stamp(self.reference.input),
                "reference_frame": self.reference.frame,
                "same_strength": self.same_strength,
            }
        return known


def _replaces_input(item: Item) -> bool:
    return identity(item.output) == identity(item.input)


def run_batch(batch: Batch, reporter: Reporter) -> Json:
    """Process what is not finished, and return the summary.

    Raises
    ------
    OSError
        A folder or a record cannot be written.
    """
    started = time.perf_counter()
    entries: dict[Item, Json] = {}
    made_with = {item: batch.made_with(item) for item in batch.items}
    for item in batch.items:
        record = read_record(item.record)
        if is_finished(record, made_with[item], item.output):
            entries[item] = mesh_entry(item, SKIPPED, record)
            reporter.finished(entries[item])
    open_items = [item for item in batch.items if item not in entries]
    for folder in {item.output.parent for item in open_items}:
        folder.mkdir(parents=True, exist_ok=True)
    for outcome in _outcomes(batch, open_items):
        item, error = outcome.item, outcome.error
        record = write_record(
            item.record,
            status=FAILED if error else DONE,
            made_with=made_with[item],
            output=item.output,
            account={"error": error, **outcome.account},
        )
        entries[item] = mesh_entry(item, record["status"], record)
        reporter.finished(entries[item])
    return _summary(batch, [entries[item] for item in batch.items], started)


def merge_batch(batch: Batch) -> Json:
    """Process nothing; return the summary of earlier runs with the same settings."""
    started = time.perf_counter()
    entries = []
    for item in batch.items:
        record, made_with = read_record(item.record), batch.made_with(item)
        if is_finished(record, made_with, item.output):
            entries.append(mesh_entry(item, SKIPPED, record))
        elif has_failed(record, made_with):
            entries.append(mesh_entry(item, FAILED, record))
        else:
            entries.append(mesh_entry(item, MISSING, None))
    return _summary(batch, entries, started)


def _outcomes(batch: Batch, items: Sequence[Item]) -> Iterator[Outcome]:
    if not items:
        return
    schedule = Schedule(batch.command, batch.jobs, batch.memory)
    settings, scale = settings_record(batch.settings), None
    if batch.reference is not None and batch.same_strength:
        measured = _measure(batch, batch.reference, schedule)
        if measured.error is not None:
            # Every frame needs the first one, so no process could do any of them.
            reason = f"first frame, {batch.reference.input.name}: {measured.error}"
            yield from (Outcome(item, reason, {}) for item in items)
            return
        settings, scale = measured.account["settings"], measured.account["scale"]
    tasks = [Task(item, _job(batch, item, settings, scale), first_claim(item)) for item in items]
    yield from schedule.run(tasks)


def _measure(batch: Batch, first: Item, schedule: Schedule) -> Outcome:
    """Let a worker measure the first frame, so that all frames are smoothed alike."""
    job = Job(
        str(first.input), first.frame, batch.object_name, settings_record(batch.settings), None
    )
    (outcome,) = schedule.run([Task(first, job, first_claim(first))])
    return outcome


def _job(batch: Batch, item: Item, settings: Json, scale: float | None) -> Job:
    first = batch.reference
    return Job(
        str(item.input),
        item.frame,
        batch.object_name,
        settings,
        os.path.abspath(item.output),
        None if first is None else (str(first.input), first.frame),
        scale,
        batch.refine,
    )


def _summary(batch: Batch, entries: list[Json], started: float) -> Json:
    return summary(
        entries,
        version=program_version(),
        algorithm=settings_record(batch.settings),
        arguments={
            "object": batch.object_name,
            "is_sequence": batch.reference is not None,
            "same_strength": batch.same_strength,
            "refine": batch.refine,
            "jobs": batch.jobs,
            "memory_limit": batch.memory,
        },
        seconds=time.perf_counter() - started,
    )
