"""Compare `denoise` with the smoothers in use, on meshes whose clean surface is known.

    python -m research.denoising                             the held-out shapes, main noise
    python -m research.denoising --shapes gear foot --noise normal:0.1 correlated:0.2
    python -m research.denoising --pairs FOLDER --output FOLDER --pictures
    python -m research.denoising --noise all --peers research   by kind of noise

Prints tables in Markdown. What Denoise may be tuned on is the group "tuning" alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

from tqdm import tqdm

from . import shapes, tables
from .contest import Entry, contest
from .pairs import ALL_NOISE, CLEAN, MAIN_NOISE, Pair, in_folder, made, noise_name
from .peers import IN_USE, PEERS, RESEARCH, Peer
from .pictures import picture
from .verdict import grouped, standing

GROUPS = {
    **{name: tuple(members) for name, members in shapes.GROUPS.items()},
    "all": tuple(shapes.SHAPES),
    "none": (),
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the contest on the pairs that the command line names."""
    options = _parser().parse_args(arguments)
    peers = [peer.as_published if options.published else peer for peer in _peers(options.peers)]
    entries = [
        # On a clean mesh no peer has anything to do: its best parameter would be none.
        contest(pair, [] if pair.noise == CLEAN else peers, options.cache)
        for pair in tqdm(list(_chosen(options)), unit="mesh")
    ]
    text = report(entries, peers)
    print(text)
    if options.output:
        options.output.mkdir(parents=True, exist_ok=True)
        (options.output / "tables.md").write_text(text + "\n", encoding="utf-8")
        if options.pictures:
            for entry in tqdm(_noisy(entries), unit="picture"):
                picture(entry, peers, options.output)


def report(entries: Sequence[Entry], peers: Sequence[Peer]) -> str:
    """Return all tables of a run as one text in Markdown."""
    noisy = _noisy(entries)
    clean = [entry for entry in entries if entry.pair.noise == CLEAN]
    parts = []
    if noisy:
        parts += ["## In short", tables.in_short(noisy, peers)]
        parts += ["## Mesh by mesh", tables.by_mesh(noisy, peers)]
        groups = grouped(noisy, lambda entry: entry.pair.noise)
        for title, some in (
            ("the smoothers in use, at one parameter for all meshes", IN_USE),
            ("the research literature, at its published parameters", RESEARCH),
        ):
            names = {peer.name for peer in some}
            rivals = [peer for peer in peers if peer.name in names]
            if rivals:
                found = {kind: standing(group, rivals) for kind, group in groups.items()}
                rows = {kind: (len(groups[kind]), each) for kind, each in found.items()}
                overall = standing(noisy, rivals)
                parts += [f"## Against {title}"]
                parts += [tables.by_noise(rows | {"all": (len(noisy), overall)})]
        parts += ["## Method by method", tables.by_peer(noisy, peers)]
    if clean:
        parts += ["## Clean meshes", tables.of_clean(clean)]
    return "\n\n".join(parts)


def _peers(names: Sequence[str]) -> list[Peer]:
    groups = {"research": RESEARCH, "in-use": IN_USE}
    asked = {
        name for each in names for name in [each, *(peer.name for peer in groups.get(each, ()))]
    }
    return [peer for peer in PEERS if not names or peer.name in asked]


def _noisy(entries: Sequence[Entry]) -> list[Entry]:
    return [entry for entry in entries if entry.pair.noise != CLEAN]


def _chosen(options: argparse.Namespace) -> Iterator[Pair]:
    names = options.shapes if options.shapes is not None else GROUPS[options.group]
    yield from made(names, ALL_NOISE if "all" in options.noise else options.noise)
    for folder in options.pairs:
        yield from in_folder(folder)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m research.denoising",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--group",
        choices=GROUPS,
        default="held-out",
        help="which of our shapes (default %(default)s)",
    )
    parser.add_argument(
        "--shapes", nargs="*", choices=shapes.SHAPES, metavar="NAME", help=", ".join(shapes.SHAPES)
    )
    parser.add_argument(
        "--noise",
        nargs="+",
        type=lambda text: text if text == "all" else noise_name(text),
        default=[MAIN_NOISE, CLEAN],
        metavar="KIND:AMPLITUDE",
        help=f"in edges: {', '.join(ALL_NOISE)}, or all of them (default {MAIN_NOISE} {CLEAN})",
    )
    parser.add_argument(
        "--pairs",
        nargs="+",
        type=Path,
        default=[],
        metavar="FOLDER",
        help="folders of NAME.clean.EXT and NAME.noisy.EXT, or NAME.scan.EXT and "
        "NAME.reference.EXT, as well",
    )
    parser.add_argument(
        "--peers",
        nargs="+",
        choices=["research", "in-use", *(peer.name for peer in PEERS)],
        default=[],
        metavar="NAME",
        help="only these, or only the research peers or those in use",
    )
    parser.add_argument(
        "--published", action="store_true", help="research peers at their authors' parameters alone"
    )
    parser.add_argument(
        "--cache",
        type=Path,
        metavar="FOLDER",
        help="keep scores from run to run: what an interrupted run has done is not done again",
    )
    parser.add_argument(
        "--output", type=Path, metavar="FOLDER", help="write tables.md and pictures"
    )
    parser.add_argument("--pictures", action="store_true", help="a picture per mesh, into --output")
    return parser


if __name__ == "__main__":
    main()
