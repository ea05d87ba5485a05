"""Schedule that spreads meshes over worker processes, within the memory of the machine."""

from __future__ import annotations

import queue
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from .memory_use import in_gigabytes
from .messages import Job
from .plan import Item
from .process import Events, WorkerProcess

Json = dict[str, Any]

START_BYTES = 400_000_000
"""Memory of Blender with numpy and scipy before it has a mesh: 290 MB as a module (measured)."""

READING_FACTOR = 4
"""Memory while a file is read, in multiples of its size: a first guess before the mesh is known."""

LARGE_BYTES = 1_500_000_000
"""A process that has held more ends after its mesh: freed memory does not always return."""

SECONDS_BETWEEN_LOOKS = 0.2
"""Time between checks of the memory that the processes hold, because estimates may be wrong."""


@dataclass
class Task:
    """A mesh that waits or is being processed.

    Attributes
    ----------
    item
        The mesh.
    job
        The job for the worker.
    claim
        Bytes that its process will probably need: guessed from the file, then estimated from the
        mesh.
    """

    item: Item
    job: Job
    claim: int


@dataclass(frozen=True)
class Outcome:
    """Outcome of a mesh.

    Attributes
    ----------
    item
        The mesh.
    error
        Why its output is missing or incomplete; None if all went well.
    account
        What the worker reports: report, seconds, memory.
    """

    item: Item
    error: str | None
    account: Json


@dataclass(eq=False)
class _Worker:
    process: WorkerProcess
    claim: int = 0
    task: Task | None = None


@dataclass
class Schedule:
    """The worker processes of a batch and the memory that they hold.

    Attributes
    ----------
    command
        Command that starts a worker.
    jobs
        Largest number of processes at a time.
    limit
        Bytes that the processes may hold together; None for no limit.
    """

    command: Sequence[str]
    jobs: int
    limit: int | None
    _workers: dict[WorkerProcess, _Worker] = field(default_factory=dict)
    _waiting: list[Task] = field(default_factory=list)
    _events: Events = field(default_factory=queue.SimpleQueue)

    def run(self, tasks: Iterable[Task]) -> Iterator[Outcome]:
        """Process the meshes and yield the outcome of each as soon as it is known.

        A mesh that does not fit beside the running ones waits while others are processed. If all
        together exceed the limit, the process that caused it is ended, and its mesh is tried again
        alone. Closing the generator ends the processes.
        """
        self._waiting = list(tasks)
        try:
            yield from self._refuse_too_large()
            self._hand_out()
            while any(worker.task for worker in self._workers.values()):
                try:
                    process, message = self._events.get(timeout=SECONDS_BETWEEN_LOOKS)
                except queue.Empty:
                    yield from self._end_what_holds_too_much()
                    self._hand_out()
                    continue
                worker = self._workers.get(process)
                if worker is not None:  # otherwise it was dismissed meanwhile
                    yield from self._handle(worker, message)
                    self._hand_out()
        finally:
            self.close()

    def close(self) -> None:
        """End all processes."""
        for worker in list(self._workers.values()):
            self._dismiss(worker)

    def _handle(self, worker: _Worker, message: Json) -> Iterator[Outcome]:
        event, task = message["event"], worker.task
        if event == "ended":
            del self._workers[worker.process]
            how = worker.process.how_it_ended()
            if task is not None:
                yield Outcome(task.item, how, {})
        elif task is None:  # its mesh was taken away while the message was under way
            return
        elif event == "needs":
            yield from self._admit(worker, task, int(message["bytes"]))
        elif event == "later":
            self._waiting.insert(0, task)
            self._release(worker)
        elif event in ("done", "failed"):
            account = {key: value for key, value in message.items() if key != "event"}
            yield Outcome(task.item, account.pop("error", None), account)
            worker.claim = max(worker.claim, account.get("peak_bytes") or 0)
            self._release(worker)

    def _admit(self, worker: _Worker, task: Task, needed: int) -> Iterator[Outcome]:
        task.claim = max(task.claim, needed)
        if self._fits(task, worker):
            worker.claim = max(worker.claim, task.claim)
            worker.process.send({"answer": "go"})
        elif self.limit is not None and task.claim > self.limit:
            yield self._too_large(task)
            worker.task = None
            self._dismiss(worker)
        else:
            worker.process.send({"answer": "later"})

    def _end_what_holds_too_much(self) -> Iterator[Outcome]:
        """Keep the limit where estimates were too low."""
        if self.limit is None:
            return
        held = {worker: process.held_bytes() for process, worker in self._workers.items()}
        if sum(held.values()) <= self.limit:
            return
        worst = max(held, key=lambda worker: held[worker] - worker.claim)
        task = worst.task
        del self._workers[worst.process]
        worst.process.kill()
        if task is None:
            return
        others_work = any(worker.task for worker in self._workers.values())
        if others_work and held[worst] <= self.limit:
            task.claim = self.limit  # alone next time
            self._waiting.insert(0, task)
        else:
            task.claim = held[worst]
            yield self._too_large(task, "was stopped when it held")

    def _hand_out(self) -> None:
        """Give waiting meshes to idle processes, or to new ones, as long as they fit."""
        while self._waiting:
            idle = [worker for worker in self._workers.values() if worker.task is None]
            if not idle and len(self._workers) >= self.jobs:
                return
            worker = idle[0] if idle else None
            task = next((task for task in self._waiting if self._fits(task, worker)), None)
            if task is None and idle:
                # Without the memory that an idle process still holds, a mesh may fit.
                self._dismiss(idle[0])
                continue
            if task is None:
                return
            self._waiting.remove(task)
            if worker is None:
                worker = self._start()
            worker.task = task
            worker.claim = max(worker.claim, task.claim)
            worker.process.send(task.job.message())

    def _fits(self, task: Task, worker: _Worker | None) -> bool:
        if self.limit is None:
            return True
        others = sum(each.claim for each in self._workers.values() if each is not worker)
        own = task.claim if worker is None else max(worker.claim, task.claim)
        return others + own <= self.limit

    def _refuse_too_large(self) -> Iterator[Outcome]:
        for task in list(self._waiting):
            if self.limit is not None and task.claim > self.limit:
                self._waiting.remove(task)
                yield self._too_large(task)

    def _too_large(self, task: Task, what: str = "needs about") -> Outcome:
        limit = in_gigabytes(self.limit or 0)
        return Outcome(
            task.item,
            f"{what} {in_gigabytes(task.claim)} of memory, the limit is {limit}: "
            "raise --memory, decimate the mesh, or fair it in parts",
            {"needed_bytes": task.claim},
        )

    def _start(self) -> _Worker:
        process = WorkerProcess(self.command, self._events)
        self._workers[process] = worker = _Worker(process)
        return worker

    def _release(self, worker: _Worker) -> None:
        worker.task = None
        if worker.claim > min(LARGE_BYTES, self.limit or LARGE_BYTES):
            self._dismiss(worker)

    def _dismiss(self, worker: _Worker) -> None:
        del self._workers[worker.process]
        worker.process.end()


def first_claim(item: Item) -> int:
    """Guess how much memory the process of a mesh needs while it reads the file, in bytes."""
    try:
        size = item.input.stat().st_size
    except OSError:
        size = 0
    return START_BYTES + READING_FACTOR * size
