"""How many bodies that a quadratic programme moves still walk, or stand, after starts of which each is another.

    python tools/research/program_starts.py gait2392_program_walk
    python tools/research/program_starts.py gait2392_program_walk --noise 0.05 --draws 2
    python tools/research/program_starts.py gait2392_stand --noise 0.2 --starts 20
    python tools/research/program_starts.py gait2392_rise --seed 777 --height 0.9

For docs/how-to/control-by-quadratic-programmes.md.

The root's velocity at the start is drawn from a normal distribution, in each direction of its own. Each draw is
a batch of its own, so that what has been found stands there if a later one does not end.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Annotated

import numpy as np
import typer

from warpmuscle.cli.ending import run_script
from warpmuscle.core.machine import this_machine
from warpmuscle.simulation.perturbations import none
from warpmuscle.simulation.rollout import Rollout


def main(
    scene: Annotated[str, typer.Argument(help="Scene, by name or file.")] = "gait2392_program_walk",
    noise: Annotated[float, typer.Option(help="Standard deviation of velocities, m/s.")] = 0.1,
    starts: Annotated[int, typer.Option(help="Bodies in a draw.")] = 20,
    draws: Annotated[int, typer.Option(help="So many draws, each with the next seed.")] = 1,
    seed: Annotated[int, typer.Option(help="Of the first draw.")] = 0,
    duration: Annotated[float, typer.Option(help="Simulated time, s.")] = 10.0,
    height: Annotated[float, typer.Option(help="Of the root at the end, m, for a body that is up.")] = 0.0,
    device: Annotated[str | None, typer.Option(help="Such as cuda:0.")] = None,
    threads: Annotated[int | None, typer.Option(help="Of a CPU.")] = None,
) -> None:
    """Start, and say who is still up."""
    rollout = Rollout(scene, starts, device, threads=threads)
    rollout.load()
    processor = this_machine()["processor"]
    print(f"{processor}, {rollout.device}: {scene}, {duration:g} s, starts with {noise:g} m/s", flush=True)
    for number in range(seed, seed + draws):
        begun = time.perf_counter()
        rollout.reset()
        drawn = noise * np.random.default_rng(number).normal(size=(starts, 3))
        rollout.disturb(replace(none(starts), velocity=drawn))
        rollout.run(duration)
        up = np.array([name in ("running", "completed") for name in rollout.status_names()])
        up &= rollout.state.coordinates.numpy()[:, 1] >= height
        ends = np.round(rollout.end_time()[~up], 2)
        fallen = f"; falls after {', '.join(f'{t:g}' for t in ends)} s" if ends.size else ""
        far = rollout.state.coordinates.numpy()[up, 2]
        way = f", {np.median(far):.1f} m, {far.min():.1f} at least" if far.size else ""
        print(f"seed {number}: {up.sum()} of {starts}{way}{fallen} ({time.perf_counter() - begun:.0f} s)", flush=True)


if __name__ == "__main__":
    run_script(main)
