"""What the surroundings of a walk cost: steps per second without them, and with each.

    python tools/bench_worlds.py objects --device cuda:0 --instances 5120,65536
    python tools/bench_worlds.py terrain walk56          one CPU core
    python tools/bench_worlds.py contact                 of bodies with each other: eight pairs, and all

Times are those of the process on a CPU, so that others that run there count less. All run in turns in one process,
several times; the fastest of each counts. Instances start with different velocities.
"""

from __future__ import annotations

import time
from typing import Annotated, Any

import msgspec
import numpy as np
import typer
import warp as wp

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.scene import BallObject, BodyContact, BoxObject, Held, Scene, Terrain, Treadmill, Water
from warpmuscle.scene.body_contact.pairs import biped_pairs
from warpmuscle.scene.terrain.tiles import Patch, Rough, Slope, Stairs
from warpmuscle.simulation.rollout import Rollout


def contact(scene: Scene) -> dict[str, Scene]:
    """Without contact between bodies, and with some and all pairs of a biped."""
    scene = msgspec.structs.replace(scene, body_contact=None)
    assert scene.feet is not None
    pairs = biped_pairs(scene.character, scene.feet)
    eight = [pair for pair in pairs if pair[0] not in ("pelvis", "torso")] + [("pelvis", f"{s}Lowerarm") for s in "lr"]
    return {
        "no pairs": scene,
        f"{len(eight[:8])} pairs": msgspec.structs.replace(scene, body_contact=BodyContact(pairs=eight[:8])),
        f"{len(pairs)} pairs": msgspec.structs.replace(scene, body_contact=BodyContact()),
    }


def terrain(scene: Scene) -> dict[str, Scene]:
    """On the plane, and on tiles."""
    patch = Patch((-100.0, 100.0), (-100.0, 100.0), friction=0.8)

    def on(*tiles: Any) -> Scene:
        ground = msgspec.structs.replace(scene.ground, terrain=Terrain([*tiles]) if tiles else None)
        return msgspec.structs.replace(scene, ground=ground)

    return {
        "plane": on(),
        "bumps of 1 cm": on(Rough(height=0.01, spacing=0.3)),
        "slope of 1 degree": on(Slope(np.radians(1.0))),
        "before stairs of 17 cm": on(Stairs(start=3.5)),
        "bumps with a patch": on(Rough(height=0.01, spacing=0.3, patches=[patch])),
    }


def objects(scene: Scene) -> dict[str, Scene]:
    """As it is, and with objects, a treadmill, and water."""
    box = BoxObject(position=(1.5, 0.1, 1.0), mass=2.0)
    hand = "rLowerarm" if "rLowerarm" in scene.character.bodies else next(iter(scene.character.bodies))
    belt = msgspec.structs.replace(scene.ground, treadmill=Treadmill(speed=0.1, profile=[(0.0, 0.0), (1.0, 1.0)]))
    return {
        "plain": scene,
        "a box": msgspec.structs.replace(scene, objects={"box": box}),
        "a ball in the hand": msgspec.structs.replace(scene, objects={"ball": BallObject(mass=0.1, held=Held(hand))}),
        "a treadmill": msgspec.structs.replace(scene, ground=belt),
        "water of 5 cm": msgspec.structs.replace(scene, water=Water(level=0.05)),
    }


SURROUNDINGS = {"contact": (contact, 0.05), "terrain": (terrain, 0.02), "objects": (objects, 0.02)}  # and noise, m/s


def main(
    what: Annotated[str, typer.Argument(help=", ".join(SURROUNDINGS))],
    scene: Annotated[str, typer.Argument()] = "walk56",
    device: str = "cpu",
    instances: str = "64",
    repeats: int = 5,
) -> None:
    """Print rates, and how much longer a step takes than without."""
    clock = time.process_time if device == "cpu" else time.perf_counter
    variants, noise = SURROUNDINGS[what]
    scenes = variants(msgspec.structs.replace(load(scene), duration=2.0))
    for count in map(int, instances.split(",")):
        threads = 1 if device == "cpu" else None
        rollouts = {name: Rollout(one, count, device, threads=threads) for name, one in scenes.items()}
        best = dict.fromkeys(rollouts, 0.0)
        for turn in range(1 + repeats):  # the first one compiles
            for name, rollout in rollouts.items():
                rollout.reset(noise, seed=1)
                wp.synchronize()
                begin = clock()
                rollout.run()
                wp.synchronize()
                steps = float(np.sum(rollout.end_time())) / rollout.numeric.time_step
                best[name] = max(best[name], steps / (clock() - begin) if turn else 0.0)
        for name, rate in best.items():
            more = 100 * (next(iter(best.values())) / rate - 1)
            print(f"{device}, {count} instances, {name}: {rate / 1e6:.4g} M steps/s, {more:+.1f} %")


if __name__ == "__main__":
    run_script(main)
