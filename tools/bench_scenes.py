"""Million steps a second of whole scenes, shipped or of files, on one device.

    python tools/bench_scenes.py walk56 reflex_planar --instances 5120,65536
    python tools/bench_scenes.py walk56 --instances 65536 --own
    python tools/bench_scenes.py "Gait - H0914 - Hyfydy.scone" --lanes 8

All bipeds start with noise. With `--own` each has parameters of its own near the scene's, as in a search. Steps are
those that were made: what falls makes no more. The time is that of the fastest of three runs.
"""

from __future__ import annotations

import warnings
from typing import Annotated

import msgspec
import numpy as np
import typer
import warp as wp
from bench_several_gpus import NOISE, RUNS, spread
from fastest_run import fastest_run

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.simulation.rollout import Rollout


def main(
    scenes: list[str],
    instances: Annotated[str, typer.Option(help="Batch sizes.")] = "5120,65536",
    seconds: Annotated[float, typer.Option(help="Motion of a run.")] = 1.0,
    own: Annotated[bool, typer.Option("--own", help="Parameters of its own for each instance.")] = False,
    lanes: Annotated[int | None, typer.Option(help="GPU threads that share an instance.")] = None,
    device: Annotated[str | None, typer.Option(help="cpu, cuda:0, ...")] = None,
) -> None:
    """Measure, and print a line for each scene and batch size."""
    wp.config.log_level = wp.LOG_WARNING
    warnings.simplefilter("ignore")
    for name in scenes:
        scene = msgspec.structs.replace(load(name), duration=seconds)
        for count in map(int, instances.split(",")):
            batch = Rollout(scene, count, device, lanes=lanes)
            if own:
                batch.set_parameters(spread(batch.parameters, count))
            best = fastest_run(batch, RUNS, NOISE)
            end = batch.end_time()
            rate = 1e-6 * np.rint(end / scene.time_step).sum() / best
            upright = 100.0 * np.mean(end > seconds - 0.5 * scene.time_step)
            told = f"{name}, {count} on {batch.device}, {batch.lanes} lanes"
            print(f"{told}: {rate:.1f} million steps/s, {upright:.0f} % reached the end", flush=True)


if __name__ == "__main__":
    run_script(main)
