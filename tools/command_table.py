"""Whether a policy does as it is told: speeds and turning rates over a grid, then others drawn at random.

    python tools/command_table.py walk56_by_command.h5 walk56_by_command.toml --each 64 --device cuda:0

A command is met if 95 % of the bodies that get it last their whole time, with a mean speed within 0.1 m/s of the wanted
one, and face within 15 degrees of the wanted heading at the end. They start from the scene's own initial state, with
the task's noise, and are not pushed unless asked for.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import msgspec
import numpy as np

SPEEDS, RATES = 4, 5  # of the grid
SHARE, NEAR, FACING = 0.95, 0.1, 15.0  # of the bodies; m/s; degrees
SEED = 5


def told(
    policy: Path, scene: str, commands: np.ndarray, each: int, push: float, device: str | None
) -> list[dict[str, float]]:
    """How so many bodies of each command (n, 2), m/s and rad/s, do, with pushes of up to `push`, N s."""
    from warpmuscle.core.pose import twist_angle
    from warpmuscle.formats import load
    from warpmuscle.kernels.learning.rewards import COMPLETED, DECISIONS, FORWARD
    from warpmuscle.learning.player import Player, learned_in, task_of

    learned = learned_in(policy)
    task = task_of(learned)
    variation = msgspec.structs.replace(task.variation, start_states=0, push=push)
    task = msgspec.structs.replace(task, command_time=0.0, variation=variation)
    player = Player(learned.policy, load(scene), each * len(commands), device, task, SEED)
    batch = player.batch
    batch.episodes.command.assign(commands.repeat(each, axis=0).astype(np.float32))
    for _ in range(batch.longest):
        wanted, first = batch.episodes.heading.numpy().copy(), batch.episodes.number.numpy() == 1
        q = batch.rollout.state.coordinates.numpy()[:, 3:7].copy()
        player.decide()
    away = np.degrees(np.abs((twist_angle(q, (0.0, 1.0, 0.0)) - wanted + np.pi) % (2.0 * np.pi) - np.pi))
    finished = batch.judge.gains.finished.numpy()
    lasts = first & (finished[:, COMPLETED] > 0.0)
    speed = finished[:, FORWARD] / np.maximum(finished[:, DECISIONS], 1.0)
    rows = []
    for number, (wanted_speed, rate) in enumerate(commands):
        mine = slice(number * each, (number + 1) * each)
        good = lasts[mine] & (np.abs(speed[mine] - wanted_speed) <= NEAR) & (away[mine] <= FACING)
        here = lasts[mine]
        rows.append({
            "speed": float(wanted_speed), "rate": float(rate), "lasts": float(here.mean()),
            "found": float(speed[mine][here].mean()) if here.any() else 0.0,
            "away": float(away[mine][here].mean()) if here.any() else 0.0, "good": float(good.mean()),
        })  # fmt: skip
    return rows


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("policy", type=Path)
    parser.add_argument("scene")
    parser.add_argument("--speed", type=float, nargs=2, default=(0.8, 1.6))
    parser.add_argument("--rate", type=float, nargs=2, default=(-0.3, 0.3))
    parser.add_argument("--each", type=int, default=64, help="bodies of each command")
    parser.add_argument("--push", type=float, default=0.0, help="greatest impulse, N s, as often as the task says")
    parser.add_argument("--others", type=int, default=20, help="commands drawn at random")
    parser.add_argument("--device", default=None)
    parser.add_argument("--json", type=Path, default=None)
    given = parser.parse_args()
    grid = [(v, w) for w in np.linspace(*given.rate, RATES) for v in np.linspace(*given.speed, SPEEDS)]
    low, high = zip(given.speed, given.rate, strict=True)
    drawn = np.random.default_rng(SEED).uniform(low, high, (given.others, 2))
    rows = told(
        given.policy, given.scene, np.concatenate([np.array(grid), drawn]), given.each, given.push, given.device
    )
    for title, part in (("grid", rows[: len(grid)]), ("drawn", rows[len(grid) :])):
        for r in part:
            print(f"speed {r['speed']:.2f} m/s, turning {r['rate']:+.2f} rad/s: {100 * r['lasts']:5.1f} % last, at "
                  f"{r['found']:.2f} m/s, {r['away']:4.1f} degrees off; {100 * r['good']:5.1f} % good")  # fmt: skip
        print(f"{title}: {sum(r['good'] >= SHARE for r in part)} of {len(part)} commands are met")
    if given.json is not None:
        given.json.write_text(json.dumps(rows))


if __name__ == "__main__":
    main()
