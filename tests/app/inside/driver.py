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
# A look comes before the events that Blender has received together with it are handled. On a busy
# machine the looks are as far apart as drawings, so this is what gives events the time they need.
TICKS_TO_REACT = 3
REACTION = 0.12  # seconds that Blender gets to handle a simulated event
ROW = 14  # pixels; buttons are 20 high, so a row lies well inside each

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
    pictures : dict
        Of each picture taken, where the parts of the 3D view are on it.
    """

    directory: Path
    results: dict = field(default_factory=dict)
    draws: list[float] = field(default_factory=list)
    pictures: dict[str, dict[str, str]] = field(default_factory=dict)

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
        """Tell whether one of the modal operators is at work."""
        names = [operator.bl_idname for operator in self.window.modal_operators]
        return any(name.startswith(OPERATOR) for name in names)

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

    def point_at_view(self) -> Scenario:
        """Move the pointer over the 3D view."""
        self.point(*self.middle("WINDOW"))
        yield REACTION

    def press_in_view(self, *keys: str) -> Scenario:
        """Press keys while the pointer is over the 3D view."""
        yield from self.point_at_view()
        self.press(*keys)
        yield REACTION

    def find_button(
        self, text: str, keys: str = "ctrl+c", across: float = 0.6
    ) -> Generator[float, None, tuple]:
        """Find a control of the sidebar by what Blender copies while the pointer is over it.

        Parameters
        ----------
        text : str
            Part of the copied text: with Ctrl C a button's operator, with Shift Ctrl C the data
            path of a property.
        keys : str
            What to press over each control.
        across : float
            Where to look, as a part of the sidebar's width; right of labels by default.

        Returns
        -------
        (int, int)
            Pixels of the control's middle row, from the window's lower left.
        """
        region = self.region("UI")
        x = region.x + int(across * (region.width - 20))  # the tabs are on the right
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

    def click_button(self, text: str, across: float = 0.6) -> Scenario:
        """Find a button of the sidebar by its operator, see `find_button`, and press it."""
        x, y = yield from self.find_button(text, across=across)
        yield from self.point_at_view()  # the keys have left the button without the pointer
        self.point(x, y)
        yield 0.5
        self.click(x, y)
        yield 1.0

    def scroll_down(self, kind: str) -> None:
        """Turn the wheel over a region of the 3D view until its end is in sight."""
        self.point(*self.middle(kind))
        xdotool("click", "--repeat", 30, "--delay", 30, 5)

    def drag(self, x: int, y: int, distance: int, pause: float = 2 * REACTION) -> Scenario:
        """Press the left button at a point, move sideways in eight steps, and let go."""
        self.point(x, y)
        yield REACTION
        xdotool("mousedown", 1)
        for step in range(1, 9):
            xdotool("mousemove", x + distance * step // 8, self.window.height - 1 - y)
            yield pause
        xdotool("mouseup", 1)
        yield REACTION

    def enter_value(self, x: int, y: int, value: float) -> Scenario:
        """Type a number into the field under a point."""
        self.point(x, y)
        yield REACTION
        xdotool("click", "--repeat", 2, "--delay", 60, 1)
        yield REACTION
        self.press("ctrl+a")
        xdotool("type", f"{value}")
        self.press("Return")
        yield REACTION

    # --- what a person sees ---------------------------------------------------------------------

    def picture(self, name: str) -> Scenario:
        """Save a picture of the screen as it is now, without keeping Blender from its work."""
        for area in self.window.screen.areas:
            area.tag_redraw()
        n_draws = len(self.draws)
        yield self.until(lambda: len(self.draws) > n_draws, 60, f"drawing for picture {name}")
        yield TICK  # what has been drawn is shown after the whole window has been drawn
        path = self.directory / f"{name}.png"
        camera = subprocess.Popen(["import", "-silent", "-window", "root", str(path)])
        yield self.until(lambda: camera.poll() is not None, 60, f"picture {name}")
        self.pictures[name] = {kind: self.crop_box(kind) for kind in ("UI", "WINDOW")}

    def crop_box(self, kind: str) -> str:
        """Place of a region of the 3D view on the screen, in ImageMagick's notation."""
        region = self.region(kind)
        top = self.window.height - region.y - region.height
        return f"{region.width}x{region.height}+{region.x}+{top}"

    def examine_pictures(self) -> dict:
        """Number of colours and checksum of each picture's sidebar (UI) and view (WINDOW)."""
        return {
            name: {
                kind: examine(self.directory / f"{name}.png", box) for kind, box in parts.items()
            }
            for name, parts in self.pictures.items()
        }

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


def examine(picture: Path, box: str) -> dict:
    """Number of different colours in a part of a picture (a blank one has 1), and its checksum."""
    question = ["convert", str(picture), "-crop", box, "-format", "%k %#", "info:"]
    answer = subprocess.run(question, capture_output=True, text=True, check=True).stdout
    n_colours, checksum = answer.split()
    return {"colours": int(n_colours), "checksum": checksum}


def adjust_preferences(preferences: bpy.types.Preferences) -> None:
    """Switch off what gets in the way of a test."""
    preferences.view.show_splash = False
    preferences.view.show_tooltips = False
    preferences.view.smooth_view = 0
    preferences.view.use_save_prompt = False
    preferences.use_preferences_save = False  # every scenario begins with the same ones
    # During a drag Blender would put the pointer back, away from where xdotool has left it.
    preferences.inputs.use_mouse_continuous = False
    # Rendering in software is slow: no antialiasing, and the view is not drawn with each sidebar.
    preferences.system.viewport_aa = "OFF"
    preferences.system.use_region_overlap = False


def play(scenario: Callable[[Stage], Scenario], directory: Path) -> None:
    """Run a scenario in this Blender's window, write ``result.json`` and quit Blender.

    An exception in the scenario ends it and is reported as ``results["error"]``.
    """
    adjust_preferences(bpy.context.preferences)
    stage = Stage(directory)
    steps = scenario(stage)
    stage.count_draws()
    waiting = Condition(lambda: stage.draws, 120.0, "the window's first drawing")
    since = time.monotonic()
    n_ticks = 0

    def tick() -> float | None:
        nonlocal waiting, since, n_ticks
        n_ticks += 1
        waited = time.monotonic() - since
        try:
            if isinstance(waiting, Condition):
                if not waiting.holds():
                    if waited > waiting.seconds:
                        raise TimeoutError(f"not within {waiting.seconds} s: {waiting.what}")
                    return TICK
            elif waited < waiting or (waiting > 0 and n_ticks < TICKS_TO_REACT):
                return TICK
            waiting, since, n_ticks = next(steps), time.monotonic(), 0
            return TICK
        except StopIteration:
            pass
        except Exception:  # reported to the test on the host, which fails with it
            stage.results["error"] = traceback.format_exc()
            path = str(directory / "error.png")
            subprocess.run(["import", "-silent", "-window", "root", path], check=False)
        stage.results["pictures"] = stage.examine_pictures()
        (directory / "result.json").write_text(json.dumps(stage.results, indent=1))
        with stage.context():
            bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(tick, persistent=True)
