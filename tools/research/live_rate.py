"""How much processor time the live viewer needs for a second of a walk that a policy moves, on one core.

    python tools/research/live_rate.py gait2392_by_policy.toml gait2392_by_policy.h5

For docs/tutorials/learn.md.

The viewer runs on one core, but no page waits for its pictures. What is left of each second goes into pictures, of
which there are 30 a second at most.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.machine import this_machine
from warpmuscle.core.status import Status
from warpmuscle.formats import scene_of
from warpmuscle.results.result import read
from warpmuscle.view.live import PICTURES, Live
from warpmuscle.view.policy_run import PolicyRun


def main(
    scene: Annotated[Path, typer.Argument(help="Scene of the policy.")],
    policy: Annotated[Path, typer.Argument(help="Result file with the policy.")],
    seconds: Annotated[float, typer.Option(help="Of the walk that are measured, after 2 s.")] = 20.0,
) -> None:
    """Print the processor time of the simulation and of a picture, and how many pictures there are in real time."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    learned = read(policy).learned
    if learned is None:
        raise SystemExit(f"{policy}: holds no policy")
    run = PolicyRun(scene_of(scene), learned, "cpu")
    live = Live(run, port=0)
    try:
        _processor_time(live.advance, 2.0)  # the first pictures are slower
        shown = _processor_time(live.advance, seconds)
        stood = run.status == Status.RUNNING and run.time > seconds
        alone = _processor_time(run.advance, seconds)
    finally:
        live.stop()
    picture = (shown - alone) / PICTURES
    print(f"{run.scene.name}, {'upright' if stood else 'fell'}; {this_machine()['processor']}")
    print(f"simulation and policy: {alone:.3f} s of the processor for a second of the walk")
    print(f"a picture: {1000.0 * picture:.0f} ms; in real time {min((1.0 - alone) / picture, PICTURES):.0f} a second")


def _processor_time(advance: Callable[[float], None], seconds: float) -> float:
    """Processor time, s, for a second of the walk, if it goes on by as much as there is between two pictures."""
    begin = time.process_time()
    for _ in range(round(seconds * PICTURES)):
        advance(1.0 / PICTURES)
    return (time.process_time() - begin) / seconds


if __name__ == "__main__":
    run_script(main)
