"""What ground that is not flat costs: steps per second of a walk on the plane, on bumps, on a slope, before stairs,
and with patches.

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
from bench_body_contact import print_rates

from warpmuscle.formats import load
from warpmuscle.scene import Scene, Terrain
from warpmuscle.scene.terrain.tiles import Patch, Rough, Slope, Stairs

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
        "before stairs of 17 cm": on(Terrain([Stairs(start=3.5)])),
        "bumps with a patch": on(Terrain([Rough(height=0.01, spacing=0.3, patches=[patch])])),
    }


def main(
    scene: Annotated[str, typer.Argument()] = "walk56",
    device: str = "cpu",
    instances: str = "64",
    repeats: int = 5,
) -> None:
    """Print rates, and how much longer a step takes than on the plane."""
    clock = time.process_time if device == "cpu" else time.perf_counter
    print_rates(variants(scene), "plane", NOISE, device, instances, repeats, clock)


if __name__ == "__main__":
    typer.run(main)
