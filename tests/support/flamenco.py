"""Flamenco's author API, as its documentation describes it, for compiling job types in tests.

Flamenco runs job compiler scripts in a JavaScript engine of its own; here it is QuickJS. What the
documentation and the manager's interface description (OpenAPI) promise about names, types and
values is checked as a manager would, so that a script that gets through can be submitted.

Source: https://flamenco.blender.org/usage/job-types/ and flamenco-openapi.yaml of Flamenco 3.8.
"""

from __future__ import annotations

import itertools
import json
import re
import shlex
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import quickjs

SETTING_TYPES = {"string": str, "int32": int, "float": float, "bool": bool}
SETTING_KEYS = {
    "key", "type", "subtype", "choices", "propargs", "description", "label", "default", "eval",
    "evalInfo", "visible", "required", "editable",
}  # fmt: skip
SUBTYPES = {"file_path", "dir_path", "file_name", "hashed_file_path"}
VISIBILITIES = {"visible", "hidden", "submission", "web"}
TASK_TYPES = {"blender", "ffmpeg", "file-management", "misc"}

# The objects that a script gets. `author.Task` and `author.Command` are called without `new`.
GLOBALS = """
const printed = [];
const print = (...words) => { printed.push(words.join(" ")); };
const alert = print;
const author = {
    Command(name, parameters, totalStepCount) {
        return { name, parameters, totalStepCount: totalStepCount || 0 };
    },
    Task(name, type) {
        return {
            name, type, commands: [], dependencies: [],
            addCommand(command) { this.commands.push(command); },
            addDependency(task) {
                if (!task || !task.name) throw new Error("a dependency must be a task");
                this.dependencies.push(task);
            },
        };
    },
};
const path = {
    join: (...parts) => parts.filter(part => part).join("/").replace(/\\/+/g, "/"),
    basename: text => text.replace(/\\/+$/, "").split("/").pop(),
    dirname: text => text.replace(/\\/+[^/]*$/, "") || "/",
};
const process = { platform: "linux", env: {} };
function newJob(settings) {
    return { name: "job", settings, tasks: [], addTask(task) { this.tasks.push(task); } };
}
function compiled(settings) {
    const job = newJob(settings);
    compileJob(job);
    return JSON.stringify(job.tasks.map(task => ({
        name: task.name, type: task.type, commands: task.commands,
        dependencies: task.dependencies.map(other => job.tasks.indexOf(other)),
    })));
}
"""


class CompileError(Exception):
    """The script has refused the settings; the message is the one that users get."""


@dataclass(frozen=True)
class Task:
    """A task as a manager would store it.

    Attributes
    ----------
    name, type
        As the script has chosen them.
    commands
        Name, parameters and number of steps of each.
    dependencies
        Indices of the tasks that must be done before.
    """

    name: str
    type: str
    commands: list[dict[str, Any]]
    dependencies: list[int] = field(default_factory=list)

    def blender_arguments(self, blender_arguments: str = "-b -y") -> list[str]:
        """Command line of the task's ``blender-render`` command, without the program.

        Parameters
        ----------
        blender_arguments
            Value of the variable ``{blenderArgs}`` in the manager's configuration.
        """
        (command,) = self.commands
        parameters = command["parameters"]
        assert command["name"] == "blender-render"
        assert parameters["exe"] == "{blender}"
        before = shlex.split(parameters["exeArgs"].replace("{blenderArgs}", blender_arguments))
        file = [parameters["blendfile"]] if parameters["blendfile"] else []
        return [*before, *parameters["argsBefore"], *file, *parameters["args"]]


class JobType:
    """A job compiler script, loaded as a manager loads it.

    Parameters
    ----------
    script
        The file.
    """

    def __init__(self, script: Path) -> None:
        self._context = quickjs.Context()
        self._context.eval(GLOBALS)
        self._add_function("frameChunker", frame_chunks)
        self._add_function("shellSplit", shlex.split)
        self._context.eval(script.read_text("utf-8"))
        self.definition = json.loads(self._context.eval("JSON.stringify(JOB_TYPE)"))

    def submit(self, *, blend_folder: str = "/farm", **settings: Any) -> list[Task]:
        """Submit a job as Blender's add-on does.

        Untouched settings have their defaults, numbers are of single precision, and hidden
        settings are evaluated.

        Parameters
        ----------
        blend_folder
            What ``//`` stands for.
        """
        assert set(settings) <= {setting["key"] for setting in self.definition["settings"]}
        complete = {**self.defaults(), **settings}
        for setting in self.definition["settings"]:
            if "eval" in setting and setting.get("visible") in ("web", "hidden"):
                complete[setting["key"]] = self.evaluate(setting["key"], complete, blend_folder)
            value = complete[setting["key"]]
            if setting["type"] == "float":
                complete[setting["key"]] = struct.unpack("f", struct.pack("f", value))[0]
        return self.compile(**complete)

    def evaluate(self, key: str, settings: Mapping[str, Any], blend_folder: str = "/farm") -> Any:
        """Evaluate a setting's expression; names in it are local, so loops do not see them."""
        (setting,) = [each for each in self.definition["settings"] if each["key"] == key]
        names = {
            "Path": Path,
            "abspath": lambda name: Path(blend_folder, str(name)[2:]) if str(name).startswith("//")
            else Path(name),
            "settings": SimpleNamespace(**settings),
            "jobname": "job",
            "C": SimpleNamespace(scene=SimpleNamespace(frame_start=3, frame_end=7)),
        }  # fmt: skip
        return eval(setting["eval"], {}, names)

    def compile(self, **settings: Any) -> list[Task]:
        """Compile a job from the settings that were sent; a manager adds and checks nothing.

        Raises
        ------
        CompileError
            The script throws something; the message is what users get.
        """
        try:
            tasks = json.loads(self._context.eval(f"compiled({json.dumps(settings)})"))
        except quickjs.JSException as error:
            # For a text that was thrown QuickJS adds the trace that it does not have.
            raise CompileError(str(error).removesuffix("\nundefined")) from error
        found = [Task(**task) for task in tasks]
        for index, task in enumerate(found):
            check_task(task, index)
        return found

    def defaults(self) -> dict[str, Any]:
        """Values of the settings that nobody has touched."""
        empty = {"string": "", "int32": 0, "float": 0.0, "bool": False}
        return {
            setting["key"]: setting.get("default", empty[setting["type"]])
            for setting in self.definition["settings"]
        }

    def _add_function(self, name: str, function: Any) -> None:
        def as_json(*values: Any) -> str:
            try:
                return json.dumps({"result": function(*values)})
            except ValueError as error:
                return json.dumps({"error": str(error)})

        # Functions of Python give and take plain values; lists go as JSON.
        self._context.add_callable(f"{name}AsJson", as_json)
        self._context.eval(
            f"""function {name}(...values) {{
                const answer = JSON.parse({name}AsJson(...values));
                if (answer.error) throw new Error(answer.error);
                return answer.result;
            }}"""
        )


def check_definition(definition: dict[str, Any]) -> None:
    """Check `JOB_TYPE` against the manager's interface description."""
    assert definition.keys() <= {"label", "description", "settings"}
    keys = [setting["key"] for setting in definition["settings"]]
    assert len(keys) == len(set(keys))
    for setting in definition["settings"]:
        assert setting.keys() <= SETTING_KEYS, setting
        assert setting["type"] in SETTING_TYPES
        assert re.fullmatch(r"[a-z][a-z0-9_]*", setting["key"])
        assert setting.get("visible", "visible") in VISIBILITIES
        if "subtype" in setting:
            assert setting["type"] == "string"
            assert setting["subtype"] in SUBTYPES
        if "default" in setting:
            check_value(setting, setting["default"])
        if "eval" in setting:
            compile(setting["eval"], setting["key"], "eval")


def check_value(setting: dict[str, Any], value: Any) -> None:
    """Check that a default is of the type of its setting."""
    wanted = SETTING_TYPES[setting["type"]]
    assert type(value) is wanted or (wanted is float and type(value) is int), setting["key"]
    if "choices" in setting:
        assert value in setting["choices"]


def check_task(task: Task, index: int) -> None:
    """Check a task as a manager does before it stores it."""
    assert task.name
    assert task.type in TASK_TYPES
    assert task.commands
    assert all(0 <= other < index for other in task.dependencies), "added before what it needs"
    for command in task.commands:
        parameters = command["parameters"]
        assert parameters.keys() == {"exe", "exeArgs", "argsBefore", "blendfile", "args"}
        for name in ("argsBefore", "args"):
            assert all(isinstance(each, str) for each in parameters[name]), parameters[name]


def frame_chunks(frames: str, size: int) -> list[str]:
    """Cut a list of frames, such as ``1-30, 47`` or ``1..30``, into pieces of at most `size`."""
    if size < 1:
        raise ValueError(f"invalid chunk size, must be positive number: {size}")
    numbers: set[int] = set()
    for part in frames.strip().split(","):
        match = re.fullmatch(r"\s*(\d+)(?:\s*(?:-|\.\.)\s*(\d+))?\s*", part)
        if match is None or int(match[2] or match[1]) < int(match[1]):
            raise ValueError(f'invalid range "{part}"')
        numbers |= set(range(int(match[1]), int(match[2] or match[1]) + 1))
    ordered = sorted(numbers)
    pieces = [ordered[start : start + size] for start in range(0, len(ordered), size)]
    return [",".join(_runs(piece)) for piece in pieces]


def _runs(numbers: list[int]) -> Iterator[str]:
    """Write ascending numbers, three and more in a row as ``first-last``."""
    for _, group in itertools.groupby(enumerate(numbers), key=lambda pair: pair[1] - pair[0]):
        run = [number for _, number in group]
        yield from [f"{run[0]}-{run[-1]}"] if len(run) > 2 else map(str, run)
