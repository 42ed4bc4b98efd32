"""What gaits withstand: pushes of 0.1 s, of which half are survived at what impulse, and slopes up and down.

python tools/robustness.py                               table in Markdown of the shipped gaits
python tools/robustness.py walk56 mine.toml              of these scenes, named as in `gait_table.py`
python tools/robustness.py before.toml after.toml --json robustness.json
                                                         also all numbers, such as before and after an optimisation
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
import warp as wp
from gait_table import ORIGINAL, SCENES, scene_of

from warpmuscle.core.errors import Error
from warpmuscle.core.files import replace_file
from warpmuscle.results.records import installed_versions
from warpmuscle.studies.robustness import IMPULSES, PushTrials, SlopeTrial, push_trials, slope_trials

SLOPE = 5.0  # deg, up and down
SECONDS_ON_SLOPE = 20.0


def push_cells(trials: PushTrials) -> tuple[str, str]:
    """The impulse that half survive, and its range, as words."""
    greatest = float(trials.impulses[-1])
    if trials.half == 0.0:
        return "falls without a push", ""
    low, high = ("more" if np.isinf(end) else f"{end:.0f}" for end in trials.range)
    half = f"more than {greatest:g}" if np.isinf(trials.half) else f"{trials.half:.0f}"
    return half, f"{low} to {high}"


def slope_cell(trial: SlopeTrial) -> str:
    """How it went on a slope, as words."""
    if trial.survived:
        return f"{trial.speed:.2f} m/s"
    return f"falls at {trial.end_time:.1f} s"


def row(name: str, pushes: PushTrials, slopes: list[SlopeTrial]) -> str:
    """A line of the table."""
    survived = " ".join(f"{100.0 * part:.0f}" for part in pushes.survived.mean(axis=1)[1:])
    cells = [f"`{name}`", *push_cells(pushes), survived, *(slope_cell(trial) for trial in slopes)]
    return f"| {' | '.join(cells)} |"


def numbers(name: str, pushes: PushTrials, slopes: list[SlopeTrial]) -> dict[str, Any]:
    """All numbers of a gait, fit for JSON; what is infinite is null."""
    ends = [None if np.isinf(value) else value for value in (pushes.half, *pushes.range)]
    return {
        "name": name,
        "half_impulse": ends[0],
        "half_impulse_range": ends[1:],
        "impulses": pushes.impulses.tolist(),
        "survived": pushes.survived.sum(axis=1).tolist(),
        "pushes": pushes.survived.shape[1],
        "slopes": [
            {"slope_deg": float(np.degrees(trial.slope)), "survived": trial.survived, "end_time": trial.end_time,
             "speed": trial.speed}
            for trial in slopes
        ],
    }  # fmt: skip


def main(
    scenes: Annotated[list[str] | None, typer.Argument(help="Scenes; by default the shipped gaits.")] = None,
    pushes: Annotated[int, typer.Option(min=1, help="Pushes at each impulse.")] = 20,
    impulse: Annotated[list[float] | None, typer.Option(help="Impulse of pushes, N s; once for each level.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of directions and times.")] = 1,
    slope: Annotated[float, typer.Option(help="Slope, degrees, up and down.")] = SLOPE,
    duration: Annotated[float, typer.Option(min=1.0, help="On a slope, s.")] = SECONDS_ON_SLOPE,
    device: Annotated[str, typer.Option(help="cpu, cuda:0, ...")] = "cpu",
    threads: Annotated[int | None, typer.Option(min=1, help="CPU threads.")] = None,
    output: Annotated[Path | None, typer.Option("--json", help="File for all numbers.")] = None,
) -> None:
    """Print what gaits withstand."""
    wp.config.log_level = wp.LOG_WARNING
    levels = impulse or list(IMPULSES)
    shown = " ".join(f"{level:g}" for level in sorted(set(levels)))
    on_slopes = [f"{sign * slope:+g} deg, {duration:g} s" for sign in (-1, 1)]
    heads = ["gait", "half survive, N s", "5 to 95 %", f"survive {shown} N s, %", *on_slopes]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    results = []
    try:
        found = {name: scene_of(name) for name in scenes or (ORIGINAL, *SCENES)}
        for name, scene in found.items():
            pushed = push_trials(scene, levels, pushes, seed=seed, device=device, threads=threads)
            inclined = slope_trials(
                scene, np.radians([-slope, slope]).tolist(), duration, device=device, threads=threads
            )
            lines.append(row(name, pushed, inclined))
            results.append(numbers(name, pushed, inclined))
        if output is not None:
            table = {"versions": installed_versions(), "seed": seed, "gaits": results}
            replace_file(output, json.dumps(table, indent=1).encode() + b"\n")
    except Error as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from None
    typer.echo("\n".join(lines))


if __name__ == "__main__":
    typer.run(main)
