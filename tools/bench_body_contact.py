"""What contact between bodies costs: steps per second of a walk without it, with eight pairs of bodies, and with all.

    python tools/bench_body_contact.py --device cuda:0 --instances 5120,65536
    python tools/bench_body_contact.py                   one CPU core

All run in turns in one process, several times; the fastest of each counts. Instances start with different velocities.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Annotated

import msgspec
import numpy as np
import typer
import warp as wp

from warpmuscle.formats import load
from warpmuscle.scene import BodyContact, Scene
from warpmuscle.scene.body_contact.pairs import biped_pairs
from warpmuscle.simulation.rollout import Rollout

NOISE = 0.05  # m/s, of the start


def variants(name: str) -> dict[str, Scene]:
    """The scene without contact between bodies, and with some and all pairs of a biped."""
    scene = load(name)
    scene = msgspec.structs.replace(scene, body_contact=None, duration=2.0)
    assert scene.feet is not None
    pairs = biped_pairs(scene.character, scene.feet)
    eight = [pair for pair in pairs if pair[0] not in ("pelvis", "torso")] + [("pelvis", f"{s}Lowerarm") for s in "lr"]
    return {
        "no pairs": scene,
        f"{len(eight[:8])} pairs": msgspec.structs.replace(scene, body_contact=BodyContact(pairs=eight[:8])),
        f"{len(pairs)} pairs": msgspec.structs.replace(scene, body_contact=BodyContact()),
    }


def main(
    scene: Annotated[str, typer.Argument()] = "walk56",
    device: str = "cpu",
    instances: str = "64",
    repeats: int = 5,
) -> None:
    """Print rates, and their ratios to that without contact."""
    print_rates(variants(scene), "no pairs", NOISE, device, instances, repeats, time.perf_counter)


def print_rates(
    scenes: dict[str, Scene], plain: str, noise: float, device: str, instances: str, repeats: int,
    clock: Callable[[], float],
) -> None:  # fmt: skip
    """Print rates of scenes that run in turns, and how much longer a step takes than that of the plain one.

    Args:
        noise: m/s, of the start. instances: numbers of them, with commas between. clock: what measures a run, s.
    """
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
            more = 100 * (best[plain] / rate - 1)
            print(f"{device}, {count} instances, {name}: {rate / 1e6:.4g} M steps/s, {more:+.1f} %")


if __name__ == "__main__":
    typer.run(main)
