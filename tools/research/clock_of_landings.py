"""When the feet of a policy land and leave, on the clock of the gait that it imitates.

For docs/tutorials/learn.md.

python tools/research/clock_of_landings.py policy.h5 task.toml --speed 1.25

A foot of the imitated gait lands at 0 % and, of a person, leaves at 62 %. What is late here is late by this share of a
cycle in every angle, even where the policy bends each joint as the clock says.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from msgspec.structs import replace

from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.formats import scene_of
from warpmuscle.gait.cycles import body_weight
from warpmuscle.learning.player import Player, learned_in

STILL: dict[str, Any] = dict.fromkeys(
    ("velocity_noise", "push", "delay", "noise", "mass", "strength", "side_strength"), 0.0
)
INSTANCES, SEED = 4, 3
SETTLED, SECONDS = 3.0, 8.0
CARRIES = 0.03  # body weights, from which on a foot is on the ground
GAP = 0.1  # s, that a foot is in the air at least


def changes(on: Floats, gap: int) -> list[int]:
    """Decisions in which a foot begins to carry (n,), after it has been in the air for so many."""
    return [k for k in np.flatnonzero(on[1:] & ~on[:-1]) + 1 if k >= gap and not on[k - gap : k].any()]


def mean_phase(phases: list[float]) -> tuple[float, float]:
    """Mean and spread of parts of a cycle, %, the mean within -50 and 50."""
    middle = np.angle(np.exp(2j * np.pi * np.array(phases)).mean()) / (2.0 * np.pi)
    away = (np.array(phases) - middle + 0.5) % 1.0 - 0.5
    return 100.0 * float(middle + away.mean()), 100.0 * float(away.std())


def main(
    policy: Path, task: Path, speed: Annotated[list[float] | None, typer.Option(help="m/s, wanted.")] = None
) -> None:
    """Print a table, without disturbances."""
    learned, scene = learned_in(policy).policy, scene_of(str(task))
    if scene.learning is None or scene.learning.imitation is None:
        raise Error(f"{task}: nothing is imitated, so there is no clock")
    variation = replace(scene.learning.variation, commands=[], growth=0.0, **STILL)
    print("| m/s | left lands at, % | leaves | right lands at, % | leaves |\n|---|---|---|---|---|")
    for wanted in speed or [1.25]:
        asked = replace(scene.learning, speed=(wanted, wanted), variation=variation, tightening=None)
        player = Player(learned, scene, INSTANCES, "cpu", asked, SEED)
        batch, forces, phases = player.batch, [], []
        for _ in range(round(SECONDS / batch.dt)):
            player.decide()
            forces.append(batch.rollout.state.foot_force.numpy()[:, :, 1].copy())
            phases.append(batch.episodes.phase.numpy().copy())
        on = np.array(forces)[round(SETTLED / batch.dt) :] > CARRIES * body_weight(batch.rollout.numeric)
        clock, gap, cells = np.array(phases)[round(SETTLED / batch.dt) :], round(GAP / batch.dt), []
        for side, lag in enumerate((0.0, 0.5 if batch.gait is None else batch.gait.right)):
            for leaves, carrying in enumerate((on[:, :, side], ~on[:, :, side])):
                at = [float(clock[k, i]) - lag for i in range(INSTANCES) for k in changes(carrying[:, i], gap)]
                middle, spread = mean_phase(at) if at else (np.nan, np.nan)
                cells.append(f"{middle % 100.0 if leaves else middle:.1f} ± {spread:.1f}")
        print(f"| {wanted:g} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    run_script(main)
