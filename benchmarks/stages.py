"""The stages of the core's work, and a clock that times them by wrapping their functions.

Functions that run in several threads at once count with the sum of their threads' times, divided
by the number of threads. A stage's time is without that of the stages it calls. Processor times
add up over all threads; they tell less than the clock on the wall when the machine is idle, and
more when it is busy.
"""

from __future__ import annotations

import functools
import importlib
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import Any, NamedTuple

from measuring import Stopwatch

from adaptive_fairing.core.runtime.threads import n_threads, ordered_map

CORE = "adaptive_fairing.core."


class Stage(NamedTuple):
    """A function of the core: its name in the table, and where it is.

    `place` is "module:name" or "module:Class.name", in the module that calls it by that name.
    """

    label: str
    place: str


SETUP = (
    Stage("ordering", "mesh.solver_mesh:sweep_order"),
    Stage("topology", "mesh.solver_mesh:TriangleTopology"),
    Stage("patches", "problem.prepared_mesh:PatchSet"),
    Stage("patches", "loop.patches:PatchSet._segments"),
    Stage("tables", "fem.table_cache:basis_table"),
    Stage("tables", "fem.table_cache:PatchTables"),
    Stage("chunks", "fem.loop_space:Chunk"),
    Stage("pattern", "fem.loop_space:SymmetricPattern"),
    Stage("entries of chunks", "fem.loop_space:ChunkEntries"),
)

STEP = (
    Stage("density", "diffusion.steps:mesh_density"),
    Stage("evaluation", "fem.loop_space:evaluate"),
    Stage("coefficients", "fem.forms:ScalarForm.coefficients"),
    Stage("measures", "fem.loop_space:integrate_measures"),
    Stage("local matrices", "fem.patch_tables:PatchTables.local_matrices"),
    Stage("scatter, right side", "fem.loop_space:_integrate"),
    Stage("sum of chunks, waiting", "fem.loop_space:LoopSpace.step_system"),
    Stage("conjugate gradients", "diffusion.steps:conjugate_gradients"),
)


class _Frame:
    """A timed call under way: what of its time belongs to stages that it called."""

    def __init__(self, label: str, foreign: float) -> None:
        self.label = label
        self.processor_at_start = time.thread_time()
        self.nested = 0.0
        self.nested_processor = 0.0
        self.foreign_at_start = foreign
        self.nested_foreign = 0.0


class Clock:
    """Adds up the seconds of stages.

    Attributes
    ----------
    seconds, processor : Counter
        Wall-clock and processor seconds by label.
    """

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()
        self.processor: Counter[str] = Counter()
        self._foreign = 0.0  # share of work in other threads than the main one
        self._lock = threading.Lock()
        self._open = threading.local()

    @contextmanager
    def watching(self, stages: tuple[Stage, ...]) -> Iterator[None]:
        """Replace the stages' functions by timed ones for a while."""
        replaced = []
        try:
            for stage in stages:
                module_name, _, path = stage.place.partition(":")
                *outer, name = path.split(".")
                module = importlib.import_module(CORE + module_name)
                owner = functools.reduce(getattr, outer, module)
                original = getattr(owner, name)
                setattr(owner, name, self._timed(stage.label, original))
                replaced.append((owner, name, original))
            for module in _modules_of_core():
                if vars(module).get("ordered_map") is ordered_map:
                    module.ordered_map = self._credited_map
                    replaced.append((module, "ordered_map", ordered_map))
            yield
        finally:
            for owner, name, original in reversed(replaced):
                setattr(owner, name, original)

    def _timed(self, label: str, function: Callable[..., object]) -> Callable[..., object]:
        @functools.wraps(function, updated=())
        def wrapper(*arguments: object, **named: object) -> object:
            is_main = threading.current_thread() is threading.main_thread()
            outer = getattr(self._open, "frame", None)
            frame = self._open.frame = _Frame(label, self._foreign)
            watch = Stopwatch()
            try:
                return function(*arguments, **named)
            finally:
                seconds = watch.seconds()
                self._open.frame = outer
                self._add(label, seconds, frame, outer, is_main)

        return wrapper

    def _credited_map(self, function: Callable[[Any], Any], items: Sequence[Any]) -> Iterator[Any]:
        """Do as `ordered_map`, but let the processor time of its threads count for the caller."""
        caller = getattr(self._open, "frame", None)
        if caller is None:
            return ordered_map(function, items)

        def credited(item: Any) -> Any:
            outer = getattr(self._open, "frame", None)
            frame = self._open.frame = _Frame(caller.label, self._foreign)
            try:
                return function(item)
            finally:
                self._open.frame = outer
                processor = time.thread_time() - frame.processor_at_start
                with self._lock:
                    self.processor[caller.label] += processor - frame.nested_processor
                if outer is not None:  # no thread of its own: part of the calling stage
                    outer.nested += frame.nested
                    outer.nested_foreign += frame.nested_foreign
                    outer.nested_processor += processor

        return ordered_map(credited, items)

    def _add(
        self, label: str, seconds: float, frame: _Frame, outer: _Frame | None, is_main: bool
    ) -> None:
        own = seconds - frame.nested
        processor = time.thread_time() - frame.processor_at_start
        with self._lock:
            if is_main:
                # While the main thread waited, others worked: that is counted as theirs.
                foreign = self._foreign - frame.foreign_at_start
                own -= foreign - frame.nested_foreign
                if outer is not None:
                    outer.nested_foreign += foreign
            else:
                own /= n_threads()
                self._foreign += own
            self.seconds[label] += own
            self.processor[label] += processor - frame.nested_processor
        if outer is not None:
            outer.nested += seconds
            outer.nested_processor += processor


def _modules_of_core() -> list[ModuleType]:
    return [module for name, module in sys.modules.items() if name.startswith(CORE)]
