"""Numbers of the walking controller by CMA-ES: steps like people's, speeds and turns, stairs, gaps, bumps.

For docs/how-to/steer-a-walk.md.

python tools/research/steering_search.py found.json --seconds 300 --seed 1 --threads 8
python tools/research/steering_search.py found.json --seconds 300 --seed 1 --device cuda:0 --population 32
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import cma
import msgspec
import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene import Scene, Terrain
from warpmuscle.scene.number import Free
from warpmuscle.scene.terrain.tiles import Flat, Profile, Rough, Stairs

WHOLE = {  # where a search begins, and its steps
    "step_time": 0.4, "quickening": 0.3, "step_height": 0.02, "step_width": 0.03, "retreat": 0.1, "tuning": 0.15,
    "speed_gain": 0.3, "push_off": 0.2, "stance_knee": 0.06, "weight_support": 0.1, "lean": 0.04, "toe_up": 0.08,
    "straightens": 0.1, "lifts": 0.1, "rise_first": 0.06, "climb": 0.2, "root_kp": 0.5, "root_kd": 0.15,
    "sole_use": 0.15, "turn_kp": 0.05, "turn_kd": 0.04,
}  # fmt: skip
JOINTS = {
    "Hip.kp": 0.3, "Hip.kd": 0.08, "Knee.kp": 0.15, "Knee.kd": 0.03, "Ankle.kp": 0.03, "Ankle.kd": 0.004,
    "ToeJoint.kp": 0.015,
}  # fmt: skip
BOUNDS = {
    "push_off": (0.0, 3.0),
    "sole_use": (0.1, 1.0),
    "toe_up": (0.0, 0.6),
    "stance_knee": (0.02, 0.6),
    "rise_first": (0.0, 0.4),
}
NAMES = [*WHOLE, *JOINTS]
FLAT, STAIRS, BUMPS, GAPS = range(4)
TILES = [
    Flat(),
    Stairs(rise=0.17, tread=0.35, count=4, start=2.5, landing=1.5),
    Rough(height=0.05, spacing=0.3, seed=3),
    Profile(
        [(2, 0), (4, 0.2), (5, 0.2), (5.02, -0.1), (5.2, -0.1), (5.22, 0.2), (6.5, 0.2), (6.52, -0.1), (6.7, -0.1),
         (6.72, 0.2), (8, 0.2), (10, 0)]
    ),
]  # fmt: skip
DURATION, SETTLED = 13.0, 9.0  # s, and from when on a walk is measured
TURN_AT, TURN_IN, TOLD_EVERY = 4.5, 3.0, 0.25  # s, when a turn begins, how long it takes, and how often it is told
FARTHEST = 9.0  # m, that ground is moved
DEEPEST = 0.01  # m, that bodies may be inside each other, or legs pass through each other


class Case(NamedTuple):
    """What a candidate has to do."""

    tile: int
    speed: float  # m/s
    heading: float = 0.0  # rad, to which it turns within `TURN_IN`
    place: float | None = 0.0  # m, by which the ground is further ahead; None: another one in each generation


CASES = [
    Case(FLAT, 0.3), Case(FLAT, 0.7, -1.5708), Case(FLAT, 1.0), Case(FLAT, 1.1, 1.5708), Case(FLAT, 1.1, -1.5708),
    Case(FLAT, 1.3), Case(FLAT, 1.1, 1.5708), Case(FLAT, 1.6), Case(STAIRS, 0.5), Case(STAIRS, 0.55, 0.0, 0.06),
    Case(STAIRS, 0.6, 0.0, 0.12), Case(STAIRS, 0.6, 0.0, 0.3), Case(STAIRS, 0.7, 0.0, 0.2), Case(GAPS, 0.6),
    Case(GAPS, 0.9, 0.0, 0.17), *(Case(BUMPS, speed, 0.0, None) for speed in (0.6, 0.6, 0.8, 0.8, *6 * [1.0])),
]  # fmt: skip


def searched() -> Scene:
    """The scene on all grounds, its numbers free."""
    scene = msgspec.convert(msgspec.to_builtins(wm.load("steer")), Scene)
    scene.duration = DURATION
    scene.failure.self_collision = DEEPEST
    scene.commands["speed"].max = max(case.speed for case in CASES)
    for name, most in (("tile", len(TILES) - 1.0), ("place", FARTHEST)):
        scene.commands[name] = wm.scene.Command(reference=0.0, min=0.0, max=most)
    follow = {name: Free(0.0, per={name: 1.0}) for name in ("tile", "place")}
    scene.ground = msgspec.structs.replace(scene.ground, terrain=Terrain(TILES, tile=follow["tile"], z=follow["place"]))
    scene.controller.parameters["sight"] = 1.0
    let_free(scene, WHOLE, JOINTS)
    return scene


def let_free(scene: Scene, whole: Iterable[str], joints: Iterable[str]) -> None:
    """Let numbers of the walking controller be free, and gains of joints, such as Hip.kp, alike on both sides."""
    numbers, by_joint = scene.controller.parameters, scene.controller.by_joint
    for name in whole:
        numbers[name] = Free(float(numbers[name]), min=-1e3, max=1e3)
    for name in joints:
        joint, gain = name.split(".")
        left, right = (by_joint[side + joint] for side in "lr")
        left[gain] = Free(float(left[gain]), min=-1e3, max=1e3)
        right[gain] = Free(same_as=f"controller.by_joint.l{joint}.{gain}")


def free_names(rollout: wm.Rollout) -> list[str]:
    """What `let_free` calls the free numbers of a batch, in their order."""
    return [one.name.rsplit("parameters.")[-1].rsplit("by_joint.l")[-1] for one in rollout.parameters]


def people(speed: float) -> float:
    """Steps a second of people, about: 1.7 at 1.0 and 1.9 at 1.4 m/s."""
    return 1.2 + 0.52 * speed


class Trial:
    """Candidates, all of whose cases are one batch."""

    def __init__(self, population: int, threads: int, device: str) -> None:
        """Compile it."""
        self.population = population
        count = population * len(CASES)
        self.rollout = wm.Rollout(searched(), count, device, record=range(count), record_rate=50.0, threads=threads)
        names = free_names(self.rollout)
        self.order = [NAMES.index(name) for name in names]
        start = [one.value for one in self.rollout.parameters]
        self.start = np.array([start[names.index(name)] for name in NAMES])
        self.told = {key: self.every([float(getattr(case, key)) for case in CASES]) for key in ("tile", "speed")}
        self.heading = self.every([case.heading for case in CASES])

    def every(self, values: list[float]) -> Any:
        """One number a case for all candidates."""
        return np.tile(values, self.population)

    def cost(self, candidates: Any, noise: float, seed: int) -> Any:
        """Cost of each case of each candidate."""
        self.rollout.set_parameters(np.repeat(candidates[:, self.order], len(CASES), axis=0))
        drawn = np.random.default_rng(seed).uniform(0.0, FARTHEST, len(CASES))
        places = [drawn[k] if case.place is None else case.place for k, case in enumerate(CASES)]
        self.rollout.set_commands(self.told | {"place": self.every(places), "heading": 0.0})
        self.rollout.reset(velocity_noise=noise, seed=seed)
        self.rollout.run(TURN_AT)
        for share in np.linspace(0.0, 1.0, round(TURN_IN / TOLD_EVERY) + 1)[1:]:
            self.rollout.set_commands({"heading": share * self.heading}, restart=False)
            self.rollout.run(TOLD_EVERY)
        self.rollout.run()
        rows = [self.of(row, CASES[row % len(CASES)]) for row in range(self.population * len(CASES))]
        return np.array(rows).reshape(self.population, len(CASES), -1)

    def of(self, row: int, case: Case) -> tuple[float, float, float, float]:
        """Cost, end, speed and steps a second of one of them."""
        walk = self.rollout.recording(row)
        end, late = walk.time[-1], walk.time > SETTLED
        forwards = np.array([np.sin(case.heading), 0.0, np.cos(case.heading)])
        if end < DURATION - 0.1:
            return 60.0 + 100.0 * (1.0 - end / DURATION), end, np.nan, np.nan
        speed = float((walk.com_velocity[late] @ forwards).mean())
        stance = np.asarray(walk.controller_value[:, 1])[late]
        steps = float((np.diff(stance) != 0.0).sum() / (end - SETTLED))
        bounce = float(np.sqrt((walk.com_velocity[late, 1] ** 2).mean()))
        turn = walk.root_orientation[late]
        off = 2.0 * np.arctan2(turn[:, 1], turn[:, 3]) - case.heading
        sway = float(np.sqrt(np.mean(np.arctan2(np.sin(off), np.cos(off)) ** 2)))
        effort = float((walk.joint_torque[late] ** 2).sum(axis=(1, 2)).mean()) / 7e4
        if case.tile != FLAT:
            return 30.0 * abs(speed - case.speed) + 5.0 * sway + effort, end, speed, steps
        strange = abs(steps - people(case.speed)) / people(case.speed)
        cost = 60.0 * abs(speed - case.speed) + 12.0 * strange + 8.0 * bounce + 10.0 * sway + 3.0 * effort
        return cost, end, speed, steps


def main(
    out: Annotated[Path, typer.Argument(help="JSON of the numbers found")],
    seconds: Annotated[float, typer.Option(help="wall time")] = 300.0,
    seed: Annotated[int, typer.Option(help="of the search")] = 1,
    threads: Annotated[int, typer.Option(help="of the CPU")] = 1,
    device: Annotated[str, typer.Option(help="cpu or cuda:0")] = "cpu",
    population: Annotated[int, typer.Option(help="candidates of a generation")] = 16,
    noise: Annotated[float, typer.Option(help="m/s, of the root's velocity at the start")] = 0.1,
    start: Annotated[Path | None, typer.Option(help="JSON of numbers to begin with")] = None,
    sigma: Annotated[float, typer.Option(help="first step, in those of the table")] = 0.5,
) -> None:
    """Search, and write the mean of each generation."""
    trial = Trial(population, threads, device)
    steps = np.array([*WHOLE.values(), *JOINTS.values()])
    begin = trial.start.copy()
    if start is not None:
        given = json.loads(start.read_text())["numbers"]
        begin = np.array([given.get(name, value) for name, value in zip(NAMES, begin, strict=True)])
    low = np.array([BOUNDS.get(name, (0.0, 9.0))[0] for name in NAMES]) + 1e-4
    high = np.array([BOUNDS.get(name, (0.0, 9.0))[1] for name in NAMES])
    options = {"popsize": population, "seed": seed, "verbose": -9}
    strategy = cma.CMAEvolutionStrategy(np.zeros(len(NAMES)), sigma, options)
    began, generation = time.time(), 0
    while time.time() - began < seconds:
        asked = strategy.ask()
        candidates = begin + steps * np.array(asked)
        inside = np.clip(candidates, low, high)
        rows = trial.cost(inside, noise, 1000 * seed + generation)
        beyond = np.abs((candidates - inside) / steps).sum(axis=1)
        cost = rows[..., 0].mean(axis=1) + 5.0 * beyond
        strategy.tell(asked, cost)
        mean = np.clip(begin + steps * strategy.mean, low, high)
        best = int(cost.argmin())
        found = {"numbers": dict(zip(NAMES, mean.tolist(), strict=True)), "cost": float(np.median(cost))}
        found["best"] = dict(zip(NAMES, inside[best].tolist(), strict=True))
        out.write_text(json.dumps(found, indent=1))
        generation += 1
        fell = "".join("x" if end < DURATION - 0.1 else "." for end in rows[best, :, 1])
        print(
            f"{generation} {time.time() - began:.0f} s median {np.median(cost):.1f} best {cost[best]:.1f} {fell}",
            np.round(rows[best, :6, 2], 2), np.round(rows[best, :6, 3], 2), flush=True,
        )  # fmt: skip


if __name__ == "__main__":
    run_script(main)
