"""What ground that is not flat costs: steps per second of a walk on the plane, on bumps, on a slope, and with patches.

    python tools/bench_terrain.py --device cuda:0 --instances 5120,65536
    python tools/bench_terrain.py                   one CPU core

Times are those of the process on a CPU, so that others that run there count less.

All run in turns in one process, several times; the fastest of each counts. Instances start with different velocities.
"""

from __future__ import annotations

import time
from typing import Annotated

import msgspec
import numpy as np
import typer
import warp as wp

from warpmuscle.formats import load
from warpmuscle.scene import Scene, Terrain
from warpmuscle.scene.terrain.tiles import Patch, Rough, Slope
from warpmuscle.simulation.rollout import Rollout

NOISE = 0.02  # m/s, of the start


def variants(name: str) -> dict[str, Scene]:
    """The scene on the plane, and on tiles that it walks on."""
    scene = msgspec.structs.replace(load(name), duration=2.0)
    patch = Patch((-100.0, 100.0), (-100.0, 100.0), friction=0.8)

    def on(terrain: Terrain | None) -> Scene:
        return msgspec.structs.replace(scene, ground=msgspec.structs.replace(scene.ground, terrain=terrain))

    return {
        "plane": on(None),
        "bumps of 1 cm": on(Terrain([Rough(height=0.01, spacing=0.3)])),
        "slope of 1 degree": on(Terrain([Slope(np.radians(1.0))])),
        "bumps with a patch": on(Terrain([Rough(height=0.01, spacing=0.3, patches=[patch])])),
    }


def main(
    scene: Annotated[str, typer.Argument()] = "walk56",
    device: str = "cpu",
    instances: str = "64",
    repeats: int = 5,
) -> None:
    """Print rates, and how much longer a step takes than on the plane."""
    for count in map(int, instances.split(",")):
        threads = 1 if device == "cpu" else None
        clock = time.process_time if device == "cpu" else time.perf_counter
        rollouts = {name: Rollout(one, count, device, threads=threads) for name, one in variants(scene).items()}
        best = dict.fromkeys(rollouts, 0.0)
        for turn in range(1 + repeats):  # the first one compiles
            for name, rollout in rollouts.items():
                rollout.reset(NOISE, seed=1)
                wp.synchronize()
                begin = clock()
                rollout.run()
                wp.synchronize()
                steps = float(np.sum(rollout.end_time())) / rollout.numeric.time_step
                best[name] = max(best[name], steps / (clock() - begin) if turn else 0.0)
        none = best["plane"]
        for name, rate in best.items():
            print(f"{device}, {count} instances, {name}: {rate / 1e6:.4g} M steps/s, {100 * (none / rate - 1):+.1f} %")


if __name__ == "__main__":
    typer.run(main)
