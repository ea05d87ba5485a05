"""Batches and sequences on the command line: checks and the run."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..batch.conflicts import Pair, require_no_conflict
from ..batch.inputs import ArgumentsError, find_sources, is_pattern, parse_frames
from ..batch.memory_use import parse_bytes
from ..batch.plan import (
    KEYED_SUFFIX,
    Item,
    parse_format,
    parse_shard,
    plan_animation,
    plan_file_frames,
    plan_files,
    shard_of,
)
from ..batch.summary import DONE, FAILED, MISSING, SKIPPED, is_complete
from ..files.formats import BLEND, SUFFIXES, suffix_of
from .options import ENDINGS

if TYPE_CHECKING:
    from ..core import DenoiseSettings, FairingSettings

BATCH_OPTIONS = ("out_dir", "format", "jobs", "memory", "shard", "merge", "allow_failures")


@dataclass(frozen=True)
class Plan:
    """A batch as the arguments describe it.

    Attributes
    ----------
    items
        Meshes of this run.
    all_items
        Meshes of all shards.
    is_sequence
        Whether the meshes are frames of one surface.
    keyed
        File for one object with a shape key for every frame; None for no such file.
    jobs, memory
        As in `Batch`; the memory is None if no limit was given.
    """

    items: Sequence[Item]
    all_items: Sequence[Item]
    is_sequence: bool
    keyed: Path | None
    jobs: int
    memory: int | None


def plan_of(arguments: argparse.Namespace) -> Plan | None:
    """Plan the batch that the arguments describe; None if they name a single mesh.

    Raises
    ------
    ArgumentsError
        The arguments are invalid or contradict each other.
    """
    is_sequence = arguments.sequence or arguments.frames is not None
    if not is_sequence and not _is_batch(arguments):
        return None
    keyed = _keyed_output(arguments, is_sequence)
    folder = arguments.out_dir
    if folder is None and keyed is not None:
        folder = keyed.with_name(f"{keyed.stem}_frames")
    elif folder is None:
        folder = _default_folder(arguments)
    if arguments.same_strength and not is_sequence:
        raise ArgumentsError("--same-strength is for frames: add --sequence or --frames")
    if arguments.jobs is not None and arguments.jobs < 1:
        raise ArgumentsError(f"--jobs {arguments.jobs}: give a number of at least 1")
    if arguments.overwrite_inputs and is_sequence:
        raise ArgumentsError(
            "--overwrite-inputs is not for frames: they need the first one's input"
        )
    items = _items(arguments, folder, is_sequence, keyed)
    _check_conflicts(arguments, items, keyed)
    shown = items
    if arguments.shard is not None:
        shown = shard_of(items, parse_shard(arguments.shard))
    memory = None if arguments.memory is None else parse_bytes(arguments.memory)
    return Plan(shown, items, is_sequence, keyed, arguments.jobs or 1, memory)


def run_plan(
    arguments: argparse.Namespace,
    settings: DenoiseSettings | FairingSettings,
    worker_command: Sequence[str],
) -> tuple[dict[str, Any], str | None]:
    """Run the batch.

    Returns
    -------
    dict
        The summary, whether or not it is also written to a file.
    str or None
        What is missing at the end, in one line; None if every mesh has its output.

    Raises
    ------
    FairingError, OSError
        No mesh could be processed, or a file of the whole batch cannot be written.
    """
    from ..batch.run import Batch, merge_batch, run_batch
    from ..core.runtime.system_memory import available_bytes
    from ..files.atomic_files import writable_place
    from ..files.report import write_report
    from .progress import MeshProgress

    plan: Plan = arguments.plan
    for path in (arguments.report, plan.keyed):
        if path is not None:
            writable_place(path)
    batch = Batch(
        items=plan.items,
        settings=settings,
        object_name=arguments.object,
        reference=plan.all_items[0] if plan.is_sequence else None,
        same_strength=arguments.same_strength,
        # An object with a key for every frame is refined as a whole: one triangulation for all.
        refine=None if plan.keyed is not None else refinement(arguments),
        command=worker_command,
        jobs=plan.jobs,
        memory=plan.memory or available_bytes(),
    )
    if arguments.merge:
        account = merge_batch(batch)
    else:
        progress = MeshProgress(
            len(plan.items),
            show_bar=not arguments.quiet and sys.stderr.isatty(),
            farm_lines=arguments.flamenco,
        )
        try:
            account = run_batch(batch, progress)
        finally:
            progress.close()
    if arguments.report is not None:
        write_report(arguments.report, account)
    if not is_complete(account["meshes"]):
        return account, _what_is_missing(account)
    if plan.keyed is not None:
        from ..silence import silent_output

        with silent_output():
            from ..blender.jobs.keyed_object import write_keyed_file

        word = ENDINGS[arguments.algorithm].removeprefix("_")
        write_keyed_file(plan.items, arguments.object, plan.keyed, refinement(arguments), word=word)
    return account, None


def refinement(arguments: argparse.Namespace) -> int | None:
    """Subdivision steps for the results; 0 for limit positions alone, None for neither."""
    if arguments.refine is not None:
        return arguments.refine
    return 0 if arguments.limit else None


def describe(account: dict[str, Any]) -> str:
    """Condense a summary into one line."""
    counts = account["counts"]
    parts = [f"{counts['meshes']} meshes: {counts[DONE]} {DONE}"]
    if counts[SKIPPED]:
        parts.append(f"{counts[SKIPPED]} finished before")
    parts += [f"{counts[status]} {status}" for status in (FAILED, MISSING) if counts[status]]
    return f"{', '.join(parts)}; {account['seconds']:.1f} s"


def _is_batch(arguments: argparse.Namespace) -> bool:
    """Whether the arguments ask for more than a single mesh."""
    inputs = arguments.input
    is_asked_for = any(getattr(arguments, name) not in (None, False) for name in BATCH_OPTIONS)
    return is_asked_for or len(inputs) > 1 or Path(inputs[0]).is_dir() or is_pattern(inputs[0])


def _default_folder(arguments: argparse.Namespace) -> Path:
    """Output folder beside a single input folder.

    Raises
    ------
    ArgumentsError
        The inputs are not a single folder.
    """
    given = Path(arguments.input[0])
    if len(arguments.input) > 1 or not given.is_dir():
        raise ArgumentsError(_no_folder(arguments))
    given = given.resolve()
    return given.with_name(f"{given.name}{ENDINGS[arguments.algorithm]}")


def _no_folder(arguments: argparse.Namespace) -> str:
    """Message that the output folder is missing, or that the second file looks like an output."""
    first, last = Path(arguments.input[0]), arguments.input[-1]
    is_file = not Path(last).is_dir() and not is_pattern(last)
    if len(arguments.input) != 2 or not is_file or Path(last) == first:
        return "give the folder for the outputs with --out-dir"
    if Path(last).exists():
        return f"two INPUTs need a folder for the outputs, --out-dir; or did you mean -o {last}?"
    suffix = f".{last.lower().removeprefix('.')}"
    if suffix in SUFFIXES:
        last = f"{first.with_name(first.stem)}{ENDINGS[arguments.algorithm]}{suffix}"
    return f"{arguments.input[-1]} does not exist: did you mean -o {last}?"


def _check_conflicts(
    arguments: argparse.Namespace, items: Sequence[Item], keyed: Path | None
) -> None:
    pairs = [Pair(item.input, item.output) for item in items]
    if keyed is not None:
        pairs.append(Pair(items[0].input, keyed))
    require_no_conflict(
        pairs,
        reports=[arguments.report] if arguments.report is not None else [],
        records=[item.record for item in items],
        may_overwrite=arguments.overwrite_inputs,
    )


def _keyed_output(arguments: argparse.Namespace, is_sequence: bool) -> Path | None:
    """File for the object with a shape key for every frame, if one is asked for."""
    output = arguments.output
    if output is None:
        return None
    if not is_sequence:
        raise ArgumentsError("-o is for a single mesh: give a folder with --out-dir instead")
    if suffix_of(output) != BLEND:
        raise ArgumentsError(f"-o {output}: frames are put together in a {BLEND} file only")
    if arguments.shard is not None:
        raise ArgumentsError("-o needs all frames: give it with --merge, not with --shard")
    return output


def _items(
    arguments: argparse.Namespace, folder: Path, is_sequence: bool, keyed: Path | None
) -> list[Item]:
    suffix = None if arguments.format is None else parse_format(arguments.format)
    if is_sequence and suffix == BLEND:
        raise ArgumentsError("frames are written as mesh files: choose another --format")
    if keyed is not None:
        if suffix not in (None, KEYED_SUFFIX):
            raise ArgumentsError(f"-o puts frames together from {KEYED_SUFFIX}: omit --format")
        suffix = KEYED_SUFFIX
    sources = find_sources(arguments.input, folder)
    if arguments.frames is not None:
        if len(sources) != 1:
            raise ArgumentsError("--frames is for one animated file")
        frames = parse_frames(arguments.frames)
        return plan_animation(sources[0].path, frames, folder, suffix or KEYED_SUFFIX)
    if not arguments.sequence:
        return plan_files(sources, folder, suffix)
    if any(suffix_of(source.path) == BLEND for source in sources):
        suffix = suffix or KEYED_SUFFIX
    return plan_file_frames(sources, folder, suffix)


def _what_is_missing(account: dict[str, Any]) -> str:
    counts = account["counts"]
    n_missing = counts[FAILED] + counts[MISSING]
    first = next(mesh for mesh in account["meshes"] if mesh["status"] in (FAILED, MISSING))
    reason = first["error"] or "not tried yet"
    return (
        f"{n_missing} of {counts['meshes']} meshes have no output, the first is "
        f"{first['output']}: {reason}"
    )
