"""Drives a Blender window from inside: waits, moves the mouse, presses keys, takes pictures.

A scenario is a generator that runs inside Blender's event loop. It yields what it waits for: a
number of seconds, or a condition to become true. Mouse and keyboard are real events of the X
server (``xdotool``), so they take the same way through Blender as those of a person::

    def scenario(stage):
        stage.open_sidebar("Fairing")
        yield 1.0
        x, y = yield from stage.find_button("object.adaptive_fairing")
        stage.click(x, y)
        yield stage.until(lambda: not stage.is_running(), seconds=60)
        stage.results["keys"] = len(bpy.context.object.data.shape_keys.key_blocks)
"""

from __future__ import annotations

import json
import subprocess
import time
import traceback
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from pathlib import Path

import bpy

OPERATOR = "OBJECT_OT_adaptive_fairing"
TICK = 0.05  # seconds between two looks at what the scenario waits for
REACTION = 0.12  # seconds that Blender gets to handle a simulated event
ROW = 9  # pixels; less than the height of any button

Scenario = Generator["float | Condition", None, None]


@dataclass(frozen=True)
class Condition:
    """Something to wait for, and the seconds after which waiting is an error."""

    holds: Callable[[], object]
    seconds: float
    what: str


@dataclass
class Stage:
    """The window under test, and what a scenario has seen in it.

    Attributes
    ----------
    directory : Path
        Where pictures and ``result.json`` go.
    results : dict
        What the scenario reports to the test on the host; must suit JSON.
    draws : list of float
        Times at which the 3D view was drawn, in seconds.
    """

    directory: Path
    results: dict = field(default_factory=dict)
    draws: list[float] = field(default_factory=list)

    # --- the window -----------------------------------------------------------------------------

    @property
    def window(self) -> bpy.types.Window:
        """The only window; looked up each time, since loading a file replaces it."""
        return bpy.context.window_manager.windows[0]

    @property
    def view(self) -> bpy.types.Area:
        """The 3D view."""
        return next(area for area in self.window.screen.areas if area.type == "VIEW_3D")

    def region(self, kind: str) -> bpy.types.Region:
        """The 3D view's region of a type such as ``"WINDOW"`` or ``"UI"`` (the sidebar)."""
        return next(region for region in self.view.regions if region.type == kind)

    def context(self):
        """Context of an operator called as if the pointer were over the 3D view."""
        return bpy.context.temp_override(
            window=self.window, area=self.view, region=self.region("WINDOW")
        )

    def open_sidebar(self, category: str) -> Scenario:
        """Open the 3D view's sidebar and turn it to a tab."""
        self.view.spaces.active.show_region_ui = True
        yield 1.0  # the tabs exist once the sidebar has been drawn
        self.region("UI").active_panel_category = category
        self.region("UI").tag_redraw()
        yield 0.5

    def middle(self, kind: str) -> tuple[int, int]:
        """Centre of a region of the 3D view, in window pixels from the lower left."""
        region = self.region(kind)
        return region.x + region.width // 2, region.y + region.height // 2

    def is_running(self) -> bool:
        """Tell whether the modal operator is at work."""
        return any(operator.bl_idname == OPERATOR for operator in self.window.modal_operators)

    # --- what a person does ---------------------------------------------------------------------

    def point(self, x: int, y: int) -> None:
        """Move the pointer to window pixels counted from the lower left, as Blender does."""
        down = self.window.height - 1 - y
        xdotool("mousemove", x - 1, down, "mousemove", x, down)

    def click(self, x: int, y: int) -> None:
        """Move the pointer and press the left button."""
        self.point(x, y)
        xdotool("click", 1)

    def press(self, *keys: str) -> None:
        """Press keys one after the other; names and combinations as in ``ctrl+z``."""
        xdotool("key", *keys)

    def press_in_view(self, *keys: str) -> Scenario:
        """Press keys while the pointer is over the 3D view."""
        self.point(*self.middle("WINDOW"))
        yield REACTION
        self.press(*keys)
        yield 5 * REACTION

    def find_button(self, text: str, keys: str = "ctrl+c") -> Generator[float, None, tuple]:
        """Find a control of the sidebar by what Blender copies while the pointer is over it.

        Parameters
        ----------
        text : str
            Part of the copied text: with Ctrl C a button's operator, with Shift Ctrl C the data
            path of a property.
        keys : str
            What to press over each control.

        Returns
        -------
        (int, int)
            Pixels of the control's middle row, from the window's lower left.
        """
        region = self.region("UI")
        x = region.x + int(0.6 * (region.width - 20))  # right of labels, left of the tabs
        rows = []
        for y in range(region.y + region.height - ROW, region.y, -ROW):
            bpy.context.window_manager.clipboard = ""
            self.point(x, y)
            yield REACTION
            self.press(keys)
            yield REACTION
            if text in bpy.context.window_manager.clipboard:
                rows.append(y)
            elif rows:
                break
        if not rows:
            raise LookupError(f"no control of the sidebar copies {text!r}")
        return x, sum(rows) // len(rows)

    def enter_value(self, x: int, y: int, value: float) -> Scenario:
        """Type a number into the field under a point."""
        self.point(x, y)
        yield REACTION
        xdotool("click", "--repeat", 2, "--delay", 60, 1)
        yield 3 * REACTION
        self.press("ctrl+a")
        xdotool("type", f"{value}")
        self.press("Return")
        yield 3 * REACTION

    # --- what a person sees ---------------------------------------------------------------------

    def picture(self, name: str) -> None:
        """Save a picture of the screen and report how many colours each part of it has."""
        path = self.directory / f"{name}.png"
        subprocess.run(["import", "-silent", "-window", "root", str(path)], check=True)
        parts = {"screen": path}
        for kind in ("UI", "WINDOW"):
            region = self.region(kind)
            top = self.window.height - region.y - region.height
            box = f"{region.width}x{region.height}+{region.x}+{top}"
            parts[kind] = self.directory / f".{name}-{kind}.png"
            subprocess.run(["convert", path, "-crop", box, "+repage", parts[kind]], check=True)
        self.results.setdefault("pictures", {})[name] = {
            part: {"colours": n_colours(file), "signature": signature(file)}
            for part, file in parts.items()
        }
        for kind in ("UI", "WINDOW"):
            parts[kind].unlink()

    def count_draws(self) -> None:
        """Note the time of each drawing of the 3D view in `draws` from now on."""
        bpy.types.SpaceView3D.draw_handler_add(
            lambda: self.draws.append(time.monotonic()), (), "WINDOW", "POST_PIXEL"
        )

    @staticmethod
    def until(holds: Callable[[], object], seconds: float, what: str = "") -> Condition:
        """Something to yield: go on once `holds()` is true, fail after `seconds`."""
        return Condition(holds, seconds, what or holds.__name__)


def xdotool(*arguments: object) -> None:
    """Send events to the X server."""
    subprocess.run(["xdotool", *map(str, arguments)], check=True)


def n_colours(picture: Path) -> int:
    """Count the different colours of a picture; a blank one has 1."""
    return int(identify(picture, "%k"))


def signature(picture: Path) -> str:
    """Checksum of a picture's pixels."""
    return identify(picture, "%#")


def identify(picture: Path, form: str) -> str:
    """Ask ImageMagick about a picture."""
    command = ["identify", "-format", form, str(picture)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def play(scenario: Callable[[Stage], Scenario], directory: Path) -> None:
    """Run a scenario in this Blender's window, write ``result.json`` and quit Blender.

    An exception in the scenario ends it and is reported as ``results["error"]``.
    """
    view = bpy.context.preferences.view
    view.show_splash = False
    view.show_tooltips = False
    view.smooth_view = 0
    view.use_save_prompt = False
    stage = Stage(directory)
    steps = scenario(stage)
    stage.count_draws()
    waiting = Condition(lambda: stage.draws, 120.0, "the window's first drawing")
    since = time.monotonic()

    def tick() -> float | None:
        nonlocal waiting, since
        try:
            waited = time.monotonic() - since
            if isinstance(waiting, Condition):
                if not waiting.holds():
                    if waited > waiting.seconds:
                        raise TimeoutError(f"not within {waiting.seconds} s: {waiting.what}")
                    return TICK
            elif waited < waiting:
                return TICK
            waiting, since = next(steps), time.monotonic()
            return TICK
        except StopIteration:
            pass
        except Exception:  # reported to the test on the host, which fails with it
            stage.results["error"] = traceback.format_exc()
            stage.picture("error")
        (directory / "result.json").write_text(json.dumps(stage.results, indent=1))
        with stage.context():
            bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(tick, persistent=True)
