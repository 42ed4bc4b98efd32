"""Draw the curves that tools/bench_search.py measured: one panel a file, named after its scene.

For docs/how-to/choose-a-strategy.md.

python tools/bench_search.py walk56_person_search --until 40 --seeds 5 --options "" --json walk56_person_search.json
python tools/research/search_curves.py walk56_person_search.json -o docs/pictures/searches.png
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import matplotlib as mpl
import numpy as np
import typer

from warpmuscle.core.array_types import Floats

mpl.use("Agg")
import matplotlib.pyplot as plt

from warpmuscle.cli.ending import run_script

FIRST = 0.5  # s, before which a curve is left out
COLOURS = ("#1f4e8c", "#b5541c", "#3c7d3c", "#7a4a9c", "#8c6d1f", "#555555")


def best_at(run: dict[str, Any], times: Floats) -> Floats:
    """The best cost of a search at these times, not a number before there is one."""
    places = np.searchsorted(run["time"], times, side="right") - 1
    return np.where(places >= 0, np.asarray(run["cost"])[np.maximum(places, 0)], np.nan)


def main(
    files: Annotated[list[Path], typer.Argument(help="JSON files of tools/bench_search.py.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Picture to write.")],
    until: Annotated[float, typer.Option(help="Last time, s.")] = 40.0,
) -> None:
    """Draw medians, and all between the least and the greatest."""
    figure, axes = plt.subplots(1, len(files), figsize=(3.2 * len(files), 2.9), layout="constrained", squeeze=False)
    times = np.linspace(FIRST, until, 400)
    for ax, file in zip(axes[0], files, strict=True):
        lowest, highest = [], []
        for colour, (title, runs) in zip(COLOURS, json.loads(file.read_text()).items(), strict=False):
            costs = np.array([best_at(run, times) for run in runs])
            ax.fill_between(times, np.nanmin(costs, 0), np.nanmax(costs, 0), alpha=0.3, color=colour, lw=0)
            ax.plot(times, np.nanmedian(costs, 0), color=colour, label=title or runs[0]["strategy"])
            lowest.append(np.nanmin(costs))
            highest.append(np.nanpercentile(costs, 99))
        room = 0.05 * (max(highest) - min(lowest))
        ax.set(title=file.stem, xlabel="wall time (s)", xlim=(0, until), ylim=(min(lowest) - room, max(highest)))
        ax.spines[["top", "right"]].set_visible(False)
        if len(ax.lines) > 1:
            ax.legend(frameon=False)
    axes[0][0].set_ylabel("best cost")
    figure.savefig(output, dpi=110)


if __name__ == "__main__":
    run_script(main)
