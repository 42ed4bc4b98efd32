"""What pushes a policy withstands: the impulse that half survive, as `warpmuscle judge` finds it of scenes.

    python tools/push_table.py walk56_by_command.h5 walk56_by_command.toml --device cuda:0

Bodies start from the scene's own initial state, with the task's noise, and are told one speed. Each is pushed once, at
its root, from a random horizontal direction at a random time between 2 and 6 s, and survives if it is upright at 10 s.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.studies.robustness import AFTERWARDS, PUSHED_FROM, PUSHED_UNTIL, PushTrials

IMPULSES = (20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0)  # N s
PUSH_TIME = 0.1  # s
SEED = 5


def pushed(
    policy: Path, scene: str, impulses: list[float], pushes: int, speed: float | None, device: str | None
) -> PushTrials:
    """Which of so many pushes of each impulse, N s, bodies survive that a policy moves."""
    from warpmuscle.formats import load
    from warpmuscle.learning.player import Player, learned_in, task_of

    levels, random = np.array([0.0, *impulses]), np.random.default_rng(SEED)
    direction = random.uniform(0.0, 2.0 * np.pi, pushes)
    start = random.uniform(PUSHED_FROM, PUSHED_UNTIL, pushes)
    learned = learned_in(policy)
    task = task_of(learned)
    variation = msgspec.structs.replace(task.variation, start_states=0, push=0.0)
    task = msgspec.structs.replace(
        task, command_time=0.0, episode_time=PUSHED_UNTIL + AFTERWARDS, variation=variation,
        speed=task.speed if speed is None else (speed, speed), turning_rate=(0.0, 0.0),
    )  # fmt: skip
    player = Player(learned.policy, load(scene), len(levels) * pushes, device, task, SEED)
    batch = player.batch
    toward = np.stack([np.sin(direction), 0.0 * direction, np.cos(direction)], axis=1)
    first = np.tile(np.rint(start / batch.scene.time_step).astype(np.int32), len(levels))
    state = batch.rollout.state
    state.push.assign((levels[:, None, None] / PUSH_TIME * toward).reshape(-1, 3).astype(np.float32))
    state.push_steps.assign(np.stack([first, first + round(PUSH_TIME / batch.scene.time_step)], axis=1))
    upright = np.ones(len(levels) * pushes, dtype=bool)
    for _ in range(batch.longest):
        player.decide()
        upright &= ~batch.judge.gains.terminated.numpy().astype(bool)
    return PushTrials(levels, upright.reshape(len(levels), pushes), direction, start)


def main() -> None:
    """Print how many survive each impulse, and which half of them do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("policy", type=Path)
    parser.add_argument("scene")
    parser.add_argument("--impulses", type=float, nargs="+", default=IMPULSES, help="N s")
    parser.add_argument("--pushes", type=int, default=64, help="of each impulse")
    parser.add_argument("--speed", type=float, default=None, help="m/s, that bodies are told")
    parser.add_argument("--device", default=None)
    given = parser.parse_args()
    trials = pushed(given.policy, given.scene, list(given.impulses), given.pushes, given.speed, given.device)
    for impulse, survived in zip(trials.impulses, trials.survived, strict=True):
        print(f"{impulse:5.0f} N s: {survived.sum():4d} of {len(survived)} survive")
    low, high = trials.range
    print(f"half survive {trials.half:.0f} N s ({low:.0f} to {high:.0f})")


if __name__ == "__main__":
    main()
