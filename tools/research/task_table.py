"""How often a policy gets up from a seat, or walks with a kettlebell, from starts and with numbers that are drawn.

For docs/how-to/learn-everyday-tasks.md.

python tools/research/task_table.py sit_to_stand.h5 sit_to_stand.toml --command seat=0.475:0.55
python tools/research/task_table.py carry.h5 carry.toml --command kettlebell=8 --command kettlebell=16
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.status import Status
from warpmuscle.learning.player import Player, lasting, learned_in, task_of, undisturbed
from warpmuscle.simulation.perturbations import none

STILL = 1.0  # s at the end, whose speed and height count


def drawn(text: str, runs: int, generator: np.random.Generator) -> tuple[str, np.ndarray]:
    """A command and its values: NAME=VALUE, or drawn evenly from NAME=LOW:HIGH."""
    name, _, value = text.partition("=")
    low, _, high = value.partition(":")
    return name, generator.uniform(float(low), float(high or low), runs)


def main(
    policy: Annotated[Path, typer.Argument(help="result file with the policy")],
    scene: Annotated[Path, typer.Argument(help="scene that it was learnt in")],
    command: Annotated[list[str], typer.Option(help="NAME=VALUE or NAME=LOW:HIGH; a row for each")],
    speed: Annotated[float, typer.Option(help="m/s, wanted")] = 0.0,
    runs: Annotated[int, typer.Option(help="of each row")] = 20,
    noise: Annotated[float, typer.Option(help="m/s, of each component of the root's velocity at the start")] = 0.1,
    seed: Annotated[int, typer.Option(help="of what is drawn")] = 1,
) -> None:
    """Print a row for each command."""
    learned, body = learned_in(policy), wm.load(str(scene))
    task = msgspec.structs.replace(lasting(undisturbed(task_of(learned))), command_time=0.0)
    player = Player(learned.policy, body, runs, "cpu", task, seed, record=range(runs), record_rate=50.0)
    generator = np.random.default_rng(seed)
    print("| | last | speed, m/s | height of the centre of mass, m |\n|---|---|---|---|")
    for text in command:
        name, values = drawn(text, runs, generator)
        start = replace(none(runs), velocity=noise * generator.standard_normal((runs, 3)))
        status, _ = player.walk(start, {name: values, "speed": speed, "turning_rate": 0.0})
        lasts = status == Status.COMPLETED
        ends = []
        for run in np.flatnonzero(lasts):
            one = player.batch.rollout.recording(int(run))
            late = one.time > one.time[-1] - (STILL if speed == 0.0 else 0.5 * one.time[-1])
            ends.append((np.linalg.norm(one.com_velocity[late].mean(axis=0)), one.com[late, 1].min()))
        fast, high = np.array(ends).reshape(-1, 2).T
        shown = f"{fast.mean():.2f} | {high.min():.2f} to {high.max():.2f}" if lasts.any() else "|"
        print(f"| {text} | {lasts.sum()} of {runs} | {shown} |", flush=True)


if __name__ == "__main__":
    run_script(main)
