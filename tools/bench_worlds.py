"""What objects, a treadmill and water cost: steps per second of a walk without them, and with each.

    python tools/bench_worlds.py --device cuda:0 --instances 5120,65536
    python tools/bench_worlds.py                   one CPU core

Times are those of the process on a CPU, so that others that run there count less.

All run in turns in one process, several times; the fastest of each counts. Instances start with different velocities.
"""

from __future__ import annotations

import time
from typing import Annotated

import msgspec
import typer
from bench_body_contact import print_rates

from warpmuscle.formats import load
from warpmuscle.scene import BallObject, BoxObject, Held, Scene, Treadmill, Water

NOISE = 0.02  # m/s, of the start


def variants(name: str) -> dict[str, Scene]:
    """The scene as it is, and with each."""
    scene = msgspec.structs.replace(load(name), duration=2.0)
    box = BoxObject(position=(1.5, 0.1, 1.0), mass=2.0)
    hand = "rLowerarm" if "rLowerarm" in scene.character.bodies else next(iter(scene.character.bodies))
    treadmill = Treadmill(speed=0.1, profile=[(0.0, 0.0), (1.0, 1.0)])
    return {
        "plain": scene,
        "a box": msgspec.structs.replace(scene, objects={"box": box}),
        "a ball in the hand": msgspec.structs.replace(scene, objects={"ball": BallObject(mass=0.1, held=Held(hand))}),
        "a treadmill": msgspec.structs.replace(
            scene, ground=msgspec.structs.replace(scene.ground, treadmill=treadmill)
        ),
        "water of 5 cm": msgspec.structs.replace(scene, water=Water(level=0.05)),
    }


def main(
    scene: Annotated[str, typer.Argument()] = "walk56",
    device: str = "cpu",
    instances: str = "64",
    repeats: int = 5,
) -> None:
    """Print rates, and how much longer a step takes than without."""
    clock = time.process_time if device == "cpu" else time.perf_counter
    print_rates(variants(scene), "plain", NOISE, device, instances, repeats, clock)


if __name__ == "__main__":
    typer.run(main)
