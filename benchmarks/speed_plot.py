"""The picture of speed.py: time and memory over size, one line per program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

from .measuring import MEGABYTE, Result

MARKERS = "osD^v<>PX*hp"


def draw(series: Mapping[str, Sequence[tuple[int, Mapping[str, Result]]]], path: Path) -> None:
    """Draw all kinds of meshes into one picture, a row each.

    Parameters
    ----------
    series : by kind of mesh, (number of triangles, results by program)
    path : Path
        Picture file; its suffix says which format.
    """
    panels = (
        ("one step from scratch, s", lambda result: result.one),
        ("one more step, s", lambda result: result.step),
        ("peak memory of the process, MB", lambda result: result.peak / MEGABYTE),
    )
    names = list(dict.fromkeys(k for sizes in series.values() for _, r in sizes for k in r))
    figure, axes = pyplot.subplots(
        len(series),
        len(panels),
        figsize=(15, 4.6 * len(series)),
        squeeze=False,
        layout="constrained",
    )
    # Of each pair the strong colour, then the pale ones.
    pairs = pyplot.get_cmap("tab20").colors
    colors = pairs[::2] + pairs[1::2]
    for row, (shape, sizes) in zip(axes, series.items(), strict=True):
        for axis, (title, value) in zip(row, panels, strict=True):
            for k, name in enumerate(names):
                points = [(n, value(results[name])) for n, results in sizes if name in results]
                points = [point for point in points if point[1]]
                if points:
                    axis.loglog(
                        *zip(*points, strict=True),
                        marker=MARKERS[k % len(MARKERS)],
                        color=colors[k % len(colors)],
                        linewidth=2.5 if k == 0 else 1.2,
                        label=name,
                    )
            axis.set_title(f"{shape}: {title}")
            axis.set_xlabel("triangles")
            axis.grid(True, which="major", color="0.85")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
