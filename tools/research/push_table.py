"""Which pushes a body that stands by a quadratic programme survives, by size and direction: a table.

    python tools/research/push_table.py gait2392_stand
    python tools/research/push_table.py gait2392_stand --size 5 --size 10 --duration 10 --noise 0.05
    python tools/research/push_table.py gait2392_stand --turn 22.5

For docs/how-to/control-by-quadratic-programmes.md.

Each instance is pushed once, at 1 s, for 0.1 s at the centre of mass of its root. With `--noise` 20 more start with
other velocities of the root, which are drawn from a normal distribution.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.machine import this_machine
from warpmuscle.simulation.perturbations import none
from warpmuscle.simulation.rollout import Rollout

DIRECTIONS = ("forwards", "left ahead", "left", "left behind", "backwards", "right behind", "right", "right ahead")


def main(
    scene: Annotated[str, typer.Argument(help="Scene, by name or file.")] = "gait2392_stand",
    size: Annotated[list[float] | None, typer.Option(help="Impulses, N s; by default 5, 10, 15 and 20.")] = None,
    duration: Annotated[float, typer.Option(help="Simulated time, s.")] = 10.0,
    turn: Annotated[float, typer.Option(help="Degrees, to the left, by which all directions are turned.")] = 0.0,
    noise: Annotated[float, typer.Option(help="Of 20 further starts, m/s; none by default.")] = 0.0,
    device: Annotated[str | None, typer.Option(help="Such as cuda:0.")] = None,
) -> None:
    """Push, and say who still stands."""
    sizes = np.array(size or [5.0, 10.0, 15.0, 20.0])
    angle = 2.0 * np.pi * np.arange(len(DIRECTIONS)) / len(DIRECTIONS) + np.radians(turn)
    unit = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    push = (sizes[:, None, None] * unit).reshape(-1, 3)
    noisy = 20 if noise > 0.0 else 0
    count = len(push) + noisy
    pushes, velocity = np.zeros((count, 3)), np.zeros((count, 3))
    pushes[: len(push)] = push
    velocity[len(push) :] = noise * np.random.default_rng(0).normal(size=(noisy, 3))
    told = replace(none(count), velocity=velocity, push=pushes, push_start=np.full(count, 1.0), push_duration=0.1)
    rollout = Rollout(scene, count, device)
    rollout.disturb(told)
    rollout.run(duration)
    stands = np.array([name in ("running", "completed") for name in rollout.status_names()])
    print(f"{this_machine()}, {rollout.device}: {duration:g} s")
    names = DIRECTIONS if turn == 0.0 else [f"{one:.4g} degrees" for one in np.degrees(angle)]
    print("| pushed, N s |" + "".join(f" {name} |" for name in names))
    print("|---" * (len(DIRECTIONS) + 1) + "|")
    for one, row in zip(sizes, stands[: len(push)].reshape(-1, len(DIRECTIONS)), strict=True):
        print(f"| {one:g} |" + "".join(" stands |" if up else " falls |" for up in row))
    if noisy:
        print(f"other starts, {noise:g} m/s: {stands[len(push) :].sum()} of {noisy} stand")


if __name__ == "__main__":
    run_script(main)
