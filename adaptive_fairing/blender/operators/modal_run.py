"""Modal runs beside Blender's window: a worker thread, a timer, Esc.

From scripts, in background and in the redo panel the same operators block until the run has ended.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.app.translations import pgettext_rpt as rpt_

from ..jobs.worker_thread import Worker
from ..preferences import preferences

if TYPE_CHECKING:
    from ...core import DenoiseProgress
    from ..jobs.solve import Solve

# A run under the brush takes about as long as the looks of a usual timer are apart.
TIMER_SECONDS, SHOWN_SECONDS = 0.02, 0.1
QUIT_SECONDS = 5.0
FIRST_PHASE_SECONDS = 3.0
"""Guessed duration for a mesh of 200 000 triangles, so that the bar moves at once."""


@dataclass
class Progress:
    """Progress of the current run, for the panel and the status bar.

    Attributes
    ----------
    solves
        All meshes of the run; the thread fills in their results.
    worker
        The thread; None if the caller waits for the run.
    n_known
        Number of steps that the main thread has seen; `denoise` counts as one.
    last_news, step_seconds
        Time when the last step was seen, and its duration, in seconds.
    last_shown
        Time when the progress was last shown.
    """

    solves: list[Solve]
    worker: Worker | None
    n_known: int = 0
    last_news: float = field(default_factory=time.perf_counter)
    last_shown: float = 0.0
    step_seconds: float = 0.0
    _phase: DenoiseProgress | tuple[()] = ()
    _phase_began: float = 0.0

    def step_done(self) -> None:
        """Count a finished step."""
        now = time.perf_counter()
        self.n_known += 1
        self.step_seconds = now - self.last_news
        self.last_news = now

    @property
    def solve(self) -> Solve:
        """The current mesh."""
        return next((solve for solve in self.solves if not solve.is_over), self.solves[-1])

    @property
    def factor(self) -> float:
        """Fraction of the run that is done; within a step, guessed from the last step's time."""
        n_steps = sum(1 if each.is_denoise else each.settings.steps for each in self.solves)
        within = 0.0
        if self.solve.is_denoise:
            within = 0.0 if self.solve.is_over else self._denoise_factor()
        elif self.step_seconds > 0:
            within = min((time.perf_counter() - self.last_news) / self.step_seconds, 0.95)
        return min((self.n_known + within) / n_steps, 1.0)

    def describe_step(self) -> str:
        """Text that names the current step and the number of steps."""
        solve = self.solve
        if solve.is_denoise:
            text = self._phase_text(solve.progress)
            left = self.seconds_left()
            if left is not None:
                text += iface_(", {:.0f} s left").format(left)
        else:
            text = iface_("Step {:d} of {:d}").format(
                min(len(solve.steps) + 1, solve.settings.steps), solve.settings.steps
            )
        return f"{solve.name}: {text}" if len(self.solves) > 1 else text

    def seconds_left(self) -> float | None:
        """Estimated seconds until `denoise` of this mesh ends; None at its beginning."""
        done, passed = self._denoise_factor(), time.perf_counter() - self.last_news
        if passed < 1 or done == 0 or self.solve.is_over:
            return None
        return passed * (1 - done) / done

    def _denoise_factor(self) -> float:
        """Fraction of `denoise` that is done; it grows with time, but stays within its phase."""
        now, news = time.perf_counter(), self.solve.progress
        if news[:2] != self._phase[:2]:
            self._phase, self._phase_began = news, now
        done, at_end = news.fraction_done, news.fraction_at_end
        # A phase is expected to be as slow as those before it. For the first one there is a guess.
        usual = FIRST_PHASE_SECONDS
        if done > 0:
            usual = (self._phase_began - self.last_news) * (at_end - done) / done
        passed = (now - self._phase_began) / max(usual, SHOWN_SECONDS)
        return done + (at_end - done) * (1 - math.exp(-passed))

    def _phase_text(self, news: DenoiseProgress) -> str:
        """Text that names the current phase of `denoise`."""
        if news.phase == "filter":
            return iface_("Filtering {:d} of {:d}").format(news.number, news.total)
        if news.phase == "mix":
            return iface_("Mixing the filters")
        if news.phase == "measure":
            return iface_("Measuring the result")
        return iface_("Measuring the noise")

    def stop(self) -> None:
        """Ask the run to stop: `denoise` at once, other methods after the current step."""
        self.worker.stop()
        for solve in self.solves:
            solve.is_cancelled = True

    def solver_details(self) -> str:
        """Text with iterations and H of the current mesh's last step; empty before the first."""
        if not self.solve.steps:
            return ""
        last = self.solve.steps[-1]
        return iface_("{:d} solver iterations  ·  H at {:.1f} %").format(
            last.solve.iterations, 100 * last.curvature_ratio
        )


_progress: list[Progress] = []  # of the run that is going on; at most one


def progress() -> Progress | None:
    """Progress of the current run; None without one."""
    return _progress[0] if _progress else None


def stop_run() -> None:
    """Ask the current run to stop after the step that it is computing."""
    for each in _progress:
        each.stop()


def forget_run(wait: float = 0.0) -> None:
    """Abandon the current run; its further results are discarded."""
    stop_run()
    for each in _progress:
        each.worker.join(wait)
    _progress.clear()


def register() -> None:
    """Begin without a run."""
    _progress.clear()


def unregister() -> None:
    """End the thread: Blender is quitting, or the add-on is being disabled."""
    forget_run(QUIT_SECONDS)


class ModalRun:
    """Mix-in for operators that fair meshes.

    A subclass has two methods, which are called in the main thread. They are not abstract, because
    Blender's classes cannot have abstract methods:

    - ``prepare(context)`` reads the meshes and returns a list of solves.
    - ``conclude(context, solves, *, is_stopped)`` writes the results and returns the result of the
      operator. It is also called after a stop, with the steps that were finished by then.
    """

    _timer: bpy.types.Timer | None = None

    def execute(self, context):
        solves = self._prepared(context)
        if solves is None:
            return {"CANCELLED"}
        current = Progress(solves, None)

        def show(_part: float = 0.0) -> None:
            context.window_manager.progress_update(current.factor)

        # A run from the redo panel cannot draw a bar, so the pointer shows the progress.
        context.window_manager.progress_begin(0.0, 1.0)
        try:
            for solve in solves:
                solve.on_fraction_done = show
            for _ in self._generator(solves):
                current.step_done()
                show()
        finally:
            context.window_manager.progress_end()
        return self.conclude(context, solves, is_stopped=False)

    def invoke(self, context, event):
        if bpy.app.background:
            return self.execute(context)
        solves = self._prepared(context)
        if solves is None:
            return {"CANCELLED"}
        _progress[:] = [Progress(solves, Worker(self._generator(solves)))]
        manager = context.window_manager
        self._timer = manager.event_timer_add(TIMER_SECONDS, window=context.window)
        manager.modal_handler_add(self)
        _show_progress(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        current = progress()
        if current is None:  # given up from outside
            self._leave(context)
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            current.stop()
            _show_progress(context)
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            news, is_over = current.worker.poll()
        except BaseException:
            self._leave(context)
            raise
        for _ in news:
            current.step_done()
        if not is_over:
            if time.perf_counter() - current.last_shown >= SHOWN_SECONDS:
                _show_progress(context)
            return {"PASS_THROUGH"}
        is_stopped = current.worker.is_stopping
        self._leave(context)
        return self.conclude(context, current.solves, is_stopped=is_stopped)

    def cancel(self, context):
        """End the run, because Blender ends the operator: a file is loaded or the window closes."""
        self._leave(context)

    def _prepared(self, context: bpy.types.Context) -> list[Solve] | None:
        from ...core import FairingError
        from ...core.runtime.threads import limit_threads

        wanted = preferences()
        if wanted is not None:
            limit_threads(wanted.threads)
        try:
            return self.prepare(context)
        except FairingError as error:
            self.report({"ERROR"}, str(error))
            return None

    def _generator(self, solves: list[Solve]) -> Iterator[Solve]:
        from ..jobs.solve import run_solves

        return run_solves(solves)

    def _leave(self, context: bpy.types.Context) -> None:
        forget_run()
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        redraw_panels(context)


def redraw_panels(context: bpy.types.Context, *others: str) -> None:
    """Redraw the sidebars of all 3D views, and their regions of other types."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type in ("UI", *others):
                        region.tag_redraw()


def _show_progress(context: bpy.types.Context) -> None:
    current = progress()
    current.last_shown = time.perf_counter()
    is_denoise = current.solve.is_denoise
    if current.worker.is_stopping:
        hint = rpt_("stopping") if is_denoise else rpt_("stopping after this step")
    else:
        hint = rpt_("Esc: stop") if is_denoise else rpt_("Esc: stop, keep the finished steps")
    parts = ["Adaptive Fairing", current.describe_step(), current.solver_details(), hint]
    if context.workspace is not None:
        context.workspace.status_text_set("   ·   ".join(part for part in parts if part))
    redraw_panels(context)
