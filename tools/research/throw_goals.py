"""Throws at targets out of recorded throws, or out of the scene's own: which are met, how, and at what cost.

For docs/explanation/throwing.md.

Examples: python tools/research/throw_goals.py throws/*.csv --scene throw18_ball --each 3
python tools/research/throw_goals.py --scene throw_ball --target 6 --seed 1
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.throw.goals import Goal
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.plot import draw_throws
from warpmuscle.throw.synthesis import Throw


def row(name: str, made: Throw, seconds: float) -> str:
    """A line of the table."""
    flight = made.flight
    return (
        f"{name:22s} {made.goal!s:10s} {'met' if made.met else 'MISSED':6s} {flight.distance[0]:6.3f} m, "
        f"{flight.speed[0]:5.2f} m/s at {np.degrees(flight.angle[0]):4.0f} deg after {made.release:.2f} s, hand "
        f"{100.0 * made.clearance:3.0f} cm above the shoulder, past limits {degrees(made.past_limits)}, behind the "
        f"release {degrees(made.past_after)}, effort {made.effort:.3f}, {made.simulations:6d} simulations, "
        f"{seconds:6.1f} s of CPU  {made.lack}"
    )


def degrees(past: Mapping[str, float]) -> str:
    """Which joints pass their limits, and by how much."""
    return " and ".join(f"{name} {np.degrees(value):.2f} deg" for name, value in past.items()) or "none"


def main(
    files: Annotated[
        list[Path] | None, typer.Argument(help="Motions, as `warpmuscle throw fit` takes them; else the scene's own.")
    ] = None,
    scene: Annotated[str, typer.Option(help="The arm, with a ball in its hand.")] = "throw18_ball",
    each: Annotated[int, typer.Option(help="How many motions to begin with, spread over all.")] = 3,
    target: Annotated[list[float] | None, typer.Option(help="Distances, m.")] = None,
    explain: Annotated[bool, typer.Option(help="Look for the torque that lacks where a goal is missed.")] = True,
    number: Annotated[int | None, typer.Option("--number", "-n", help="Of synergies; else the usual number.")] = None,
    threads: Annotated[int | None, typer.Option(help="CPU threads.")] = None,
    seed: Annotated[int, typer.Option(help="Of searches.")] = 0,
    plot: Annotated[Path | None, typer.Option(help="Figure of the throws out of the last motion.")] = None,
) -> None:
    """Print a line for each pair of a recorded throw and a target."""
    chosen: Sequence[Path | None] = [None]
    if files:
        chosen = [files[k] for k in np.unique(np.linspace(0, len(files) - 1, each).round().astype(int))]
    met = total = 0
    for file in chosen:
        begin = time.process_time()
        job = Job(load(scene), [] if file is None else [file], JobOptions(count=number, threads=threads, seed=seed))
        name = job.motions.names[0]
        fitted = job.fit()
        good = "meets all bars" if fitted.agreement.good().all() else "misses a bar"
        print(f"{name}: fit of {time.process_time() - begin:.1f} s of CPU {good}", flush=True)
        throws = []
        for distance in target or [2.0, 3.0, 4.0, 5.0]:
            begin = time.process_time()
            throws += job.throw([Goal(distance)], explain=explain)
            met, total = met + throws[-1].met, total + 1
            print(row(name, throws[-1], time.process_time() - begin), flush=True)
        if plot is not None:
            draw_throws(plot, job.follower, throws)
    print(f"{met} of {total} goals are met")


if __name__ == "__main__":
    run_script(main)
