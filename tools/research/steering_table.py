"""How well the walking controller does what it is told: speeds, turns, other bodies, ground that it has not seen.

For docs/how-to/steer-a-walk.md.

python tools/research/steering_table.py                tables in Markdown; minutes of two cores
python tools/research/steering_table.py --runs 5       of fewer walks each
python tools/research/steering_table.py --scene steer56 --only speeds
python tools/research/steering_table.py --scene steer_quick --only turns --seed 7
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any

import msgspec
import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.scene import Command, Scene, Terrain
from warpmuscle.scene.number import Free
from warpmuscle.scene.sizes.batch_scene import batch_scene
from warpmuscle.scene.sizes.sized import sized
from warpmuscle.scene.terrain.tiles import Rough

SPEEDS = (0.2, 0.5, 0.8, 1.1, 1.3, 1.6, 1.8)
TURNED = (0.5, 0.8, 1.1, 1.3, 1.6, 1.8)  # m/s, of walks that turn
OVER_BUMPS = (0.6, 0.8, 1.0)  # m/s, of those over bumps
NOISE = 0.1  # m/s, of each component of the root's velocity at the start
SECONDS, SETTLED = 12.0, 6.0  # s, and from when on it is measured
TURN_AT, TURN_IN, QUARTER = 5.0, 3.0, 0.5 * np.pi
BODIES = ((1.2, 28.0), (1.4, 40.0), (1.6, 60.0), (1.75, 70.4), (1.9, 110.0), (2.0, 90.0))


def value(recording: Any, name: str) -> np.ndarray:
    """One of the controller's recorded values, (frames,)."""
    return np.asarray(recording.controller_value[:, recording.controller_value_names.index(name)])


def ran(scene: Scene, runs: int, duration: float, seed: int, **commands: Any) -> wm.Rollout:
    """Disturbed walks, all of them recorded."""
    rollout = wm.Rollout(msgspec.structs.replace(scene, duration=duration), runs, "cpu", record=range(runs))
    if commands:
        rollout.set_commands(commands)
    rollout.reset(velocity_noise=NOISE, seed=seed)
    rollout.run()
    return rollout


def upright(rollout: wm.Rollout) -> np.ndarray:
    """Which of them reached the end."""
    return np.asarray(rollout.status()) == wm.Status.COMPLETED


def clearances(recording: Any) -> np.ndarray:
    """The least clearance of each swing's middle half, m."""
    phase, clearance, stance = (value(recording, name) for name in ("phase", "clearance", "stance"))
    steps = np.flatnonzero(np.diff(stance) != 0.0) + 1
    found = []
    for first, end in pairwise(steps):
        middle = (phase[first:end] > 0.25) & (phase[first:end] < 0.65)
        if middle.any() and recording.time[first] > SETTLED:
            found.append(clearance[first:end][middle].min())
    return np.array(found)


def speeds(scene: Scene, runs: int, seed: int) -> None:
    """How fast it walks that is to walk at a speed."""
    print("| asked for, m/s | upright | walks at, m/s | error | steps/s | foot clearance, cm |")
    print("|---|---|---|---|---|---|")
    wanted = [speed for speed in SPEEDS if speed <= scene.commands["speed"].max]
    rollout = ran(scene, runs * len(wanted), SECONDS, seed, speed=np.repeat(wanted, runs))
    well = upright(rollout).reshape(len(wanted), runs)
    for row, asked in enumerate(wanted):
        walks = [rollout.recording(row * runs + run) for run in np.flatnonzero(well[row])]
        if not walks:
            print(f"| {asked:.1f} | 0 of {runs} | | | | |")
            continue
        late = [walk.time > SETTLED for walk in walks]
        speed = np.mean([walk.com_velocity[part, 2].mean() for walk, part in zip(walks, late, strict=True)])
        steps = np.mean(
            [(np.diff(value(walk, "stance")[part]) != 0).sum() for walk, part in zip(walks, late, strict=True)]
        )
        least = np.concatenate([clearances(walk) for walk in walks])
        print(
            f"| {asked:.1f} | {len(walks)} of {runs} | {speed:.2f} | {speed - asked:+.2f} |"
            f" {steps / (SECONDS - SETTLED):.2f} | {100 * np.median(least):.1f} |"
        )


def turned(recording: Any) -> np.ndarray:
    """Heading of the pelvis over time, rad, to the left."""
    y, w = recording.root_orientation[:, 1], recording.root_orientation[:, 3]
    return np.unwrap(2.0 * np.arctan2(y, w))


def turns(scene: Scene, runs: int, seed: int) -> None:
    """How it turns by 90 degrees in 3 s, half of the walks to each side."""
    print("\n| speed, m/s | upright | turning rate, degrees/s | behind in the middle, degrees | error after, degrees |")
    print("|---|---|---|---|---|")
    for asked in (speed for speed in TURNED if speed <= scene.commands["speed"].max):
        rates, behind, error = [], [], []
        for side in (1.0, -1.0):
            told = msgspec.convert(msgspec.to_builtins(scene), type(scene))
            told.commands["heading"].over = [(TURN_AT, 0.0), (TURN_AT + TURN_IN, side * QUARTER)]
            rollout = ran(told, runs // 2, TURN_AT + TURN_IN + 3.0, seed, speed=asked)
            for walk in map(rollout.recording, np.flatnonzero(upright(rollout))):
                angle, time = side * turned(walk), walk.time
                during = (time > TURN_AT + 0.5) & (time < TURN_AT + TURN_IN)
                rates.append(np.polyfit(time[during], angle[during], 1)[0])
                middle = np.abs(time - TURN_AT - 0.5 * TURN_IN) < 0.4
                behind.append(0.5 * QUARTER - angle[middle].mean())
                error.append(angle[time > TURN_AT + TURN_IN + 2.0].mean() - QUARTER)
        if not rates:
            print(f"| {asked:.1f} | 0 of {runs} | | | |")
            continue
        rate, lag, last = (np.degrees(np.mean(numbers)) for numbers in (rates, behind, np.abs(error)))
        print(f"| {asked:.1f} | {len(rates)} of {runs} | {rate:.1f} | {lag:.1f} | {last:.1f} |", flush=True)


def bodies(scene: Scene, runs: int, seed: int) -> None:
    """Bodies of other sizes on the same numbers."""
    print("\n| height, m | mass, kg | upright | walks at, m/s |")
    print("|---|---|---|---|")
    own = [sized(scene, height, mass) for height, mass in BODIES for _ in range(runs)]
    count = len(own)
    rollout = wm.Rollout(msgspec.structs.replace(scene, duration=SECONDS), count, "cpu", record=range(count))
    rollout.change(batch_scene(own))
    rollout.reset(velocity_noise=NOISE, seed=seed)
    rollout.run()
    well = upright(rollout).reshape(len(BODIES), runs)
    for row, (height, mass) in enumerate(BODIES):
        walks = [rollout.recording(row * runs + run) for run in np.flatnonzero(well[row])]
        speed = np.mean([walk.com_velocity[walk.time > SETTLED, 2].mean() for walk in walks]) if walks else np.nan
        print(f"| {height:.2f} | {mass:g} | {len(walks)} of {runs} | {speed:.2f} |")


def unseen(scene: Scene, runs: int, seed: int) -> None:
    """Bumps, another piece of ground for each walk."""
    print("\n| speed, m/s | bumps, cm, 30 cm apart | upright, feet see the ground | upright, feet do not |")
    print("|---|---|---|---|")
    places = np.random.default_rng(seed - 1).uniform(0.0, 30.0, runs)
    for speed in OVER_BUMPS:
        for height in (0.02, 0.03, 0.05):
            found = []
            for sight in (1.0, 0.0):
                over = msgspec.convert(msgspec.to_builtins(scene), Scene)
                over.commands["place"] = Command(reference=0.0, min=0.0, max=30.0)
                bumps = Terrain([Rough(height=height, spacing=0.3)], z=Free(0.0, per={"place": 1.0}))
                over.ground = msgspec.structs.replace(over.ground, terrain=bumps)
                over.controller.parameters["sight"] = sight
                found.append(int(upright(ran(over, runs, SECONDS, seed, place=places, speed=speed)).sum()))
            print(f"| {speed:.1f} | {100 * height:.0f} | {found[0]} of {runs} | {found[1]} of {runs} |", flush=True)


PARTS = {"speeds": speeds, "turns": turns, "bodies": bodies, "ground": unseen}


def main(
    runs: Annotated[int, typer.Option(help="walks of each row")] = 20,
    scene: Annotated[str, typer.Option(help="name of the scene")] = "steer",
    only: Annotated[str, typer.Option(help="speeds, turns, bodies or ground; by default all")] = "",
    seed: Annotated[int, typer.Option(help="of the noise, and of places on bumps")] = 1,
) -> None:
    """Print the tables of the page."""
    loaded = wm.load(scene)
    for name, part in PARTS.items():
        if only in ("", name):
            part(loaded, runs, seed)


if __name__ == "__main__":
    run_script(main)
