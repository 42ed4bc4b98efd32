"""Numbers of the walking controller with which it comes over the ground of `course`, by CMA-ES.

For docs/how-to/steer-a-walk.md.

python tools/research/course_search.py found.json --seconds 120 --device cuda:0
python tools/research/course_search.py found.json --seconds 600 --population 10 --walks 8
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Annotated, Any

import cma
import msgspec
import numpy as np
import typer
from steering_search import DEEPEST, free_names, let_free

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene import Command, Scene
from warpmuscle.scene.number import Free

WHOLE = {  # first steps
    "step_width": 0.03, "least_width": 0.02, "retreat": 0.05, "tuning": 0.1, "speed_gain": 0.2, "push_off": 0.1,
    "weight_support": 0.05, "straightens": 0.1, "lifts": 0.05, "turn_kp": 0.04, "turn_kd": 0.04, "root_kp": 0.3,
    "root_kd": 0.08, "climb": 0.1, "sole_use": 0.1,
}  # fmt: skip
JOINTS = {"Shoulder.kp": 0.03, "Hip.kp": 0.3, "Hip.kd": 0.05}
DURATION, SPEED, NOISE = 16.0, 0.6, 0.1  # s, m/s, and m/s of each component of the root's velocity at the start
BEFORE, SETTLED = 3.0, 6.0  # s: between them a walk has its line, from which it must not go aside later
NEAREST, FARTHEST = -0.4, 0.6  # m, that the ground is moved ahead


def searched() -> Scene:
    """The course without its turn and its stop, its numbers free."""
    scene = msgspec.convert(msgspec.to_builtins(wm.load("course")), Scene)
    scene.duration = DURATION
    scene.failure.self_collision = DEEPEST
    for name, value in (("speed", SPEED), ("heading", 0.0)):
        scene.commands[name].over = []
        scene.commands[name].value = value
    scene.commands["place"] = Command(reference=0.0, min=NEAREST, max=FARTHEST)
    terrain = scene.ground.terrain
    assert terrain is not None
    terrain.x, terrain.yaw, terrain.z = 0.0, 0.0, Free(0.0, per={"place": 1.0})
    let_free(scene, WHOLE, JOINTS)
    return scene


def cost_of(walk: Any, came_through: bool) -> float:
    """Of one walk: that it goes aside after its first steps, its speed, and that it falls."""
    late = walk.time > SETTLED
    if not late.any():
        return 200.0
    line = np.median(walk.root_position[(walk.time > BEFORE) & (walk.time < SETTLED), 0])
    aside = np.abs(walk.root_position[late, 0] - line).max()
    velocity = walk.com_velocity[late]
    cost = 20.0 * np.sqrt((velocity[:, 0] ** 2).mean()) + 5.0 * aside + 10.0 * abs(velocity[:, 2].mean() - SPEED)
    return float(cost + (0.0 if came_through else 60.0 * (2.0 - walk.time[-1] / DURATION)))


def main(
    out: Annotated[Path, typer.Argument(help="JSON of the numbers found")],
    seconds: Annotated[float, typer.Option(help="wall time")] = 120.0,
    seed: Annotated[int, typer.Option(help="of the search")] = 5,
    device: Annotated[str, typer.Option(help="cpu or cuda:0")] = "cpu",
    population: Annotated[int, typer.Option(help="candidates of a generation")] = 24,
    walks: Annotated[int, typer.Option(help="of each candidate, on ground that is moved")] = 16,
) -> None:
    """Search, and write the mean of each generation."""
    count = population * walks
    rollout = wm.Rollout(searched(), count, device, record=range(count), record_rate=10.0)
    names = free_names(rollout)
    begin = np.array([one.value for one in rollout.parameters], dtype=float)
    steps = np.array([(WHOLE | JOINTS)[name] for name in names])
    low = np.maximum(begin - 3.0 * steps, 0.01 * begin)
    strategy = cma.CMAEvolutionStrategy(np.zeros(len(names)), 0.4, {"popsize": population, "seed": seed, "verbose": -9})
    began, generation = time.time(), 0
    while time.time() - began < seconds:
        asked = strategy.ask()
        candidates = np.maximum(begin + steps * np.array(asked), low)
        drawn = 100 * seed + generation
        places = np.random.default_rng(drawn).uniform(NEAREST, FARTHEST, walks)
        rollout.set_parameters(np.repeat(candidates, walks, axis=0))
        rollout.set_commands({"place": np.tile(places, population)})
        rollout.reset(velocity_noise=NOISE, seed=drawn)
        rollout.run()
        through = np.asarray(rollout.status()) == wm.Status.COMPLETED
        each = [cost_of(rollout.recording(k), bool(through[k])) for k in range(count)]
        cost = np.array(each).reshape(population, walks).mean(axis=1)
        strategy.tell(asked, cost.tolist())
        mean = np.maximum(begin + steps * strategy.mean, low)
        out.write_text(json.dumps(dict(zip(names, mean.tolist(), strict=True)), indent=1) + "\n")
        generation += 1
        fell = (~through).reshape(population, walks).sum(axis=1)
        print(
            f"{generation} {time.time() - began:.0f} s median {np.median(cost):.2f} best {cost.min():.2f} falls {fell}"
        )


if __name__ == "__main__":
    run_script(main)
