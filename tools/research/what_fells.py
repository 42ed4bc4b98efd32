"""Which disturbances of its task fell a policy, and what each reward earns.

For docs/tutorials/learn.md.

python tools/research/what_fells.py policy.h5 task.toml --instances 64
python tools/research/what_fells.py policy.h5 task.toml --speed 1.75 --instances 16

Each row has one kind of disturbance of the task's variation, the first none and the last all. Policies act without
noise of their own. Rewards are those a second, of bodies that reached the end.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from msgspec.structs import replace

from warpmuscle.cli.ending import run_script
from warpmuscle.core.errors import Error
from warpmuscle.formats import scene_of
from warpmuscle.kernels.learning.rewards import COMPLETED, COUNT, DECISIONS, FORWARD
from warpmuscle.learning.player import Player, learned_in

KINDS = {
    "start": ("velocity_noise",), "pushes": ("push",), "nerves": ("delay", "noise"),
    "body": ("mass", "strength", "side_strength"), "ground, load": ("commands",),
}  # fmt: skip
SEED = 3


def main(
    policy: Path,
    task: Path,
    instances: Annotated[int, typer.Option(min=1, help="Bodies of each row.")] = 64,
    speed: Annotated[float | None, typer.Option(help="m/s, wanted of all; by default drawn as in the task.")] = None,
) -> None:
    """Print a table, and the rewards without disturbances."""
    learned, scene = learned_in(policy).policy, scene_of(str(task))
    if scene.learning is None:
        raise Error(f"{task}: the scene has no [learning]")
    wanted = scene.learning if speed is None else replace(scene.learning, speed=(speed, speed))
    given = wanted.variation
    still: dict[str, Any] = {name: [] if name == "commands" else 0.0 for names in KINDS.values() for name in names}
    text = ""
    cases = {"none": (), **KINDS, "all": tuple(still)}
    print("| disturbance | reached the end | upright, s | m/s |\n|---|---|---|---|")
    for case, names in cases.items():
        variation = replace(given, **still | {name: getattr(given, name) for name in names})
        player = Player(learned, scene, instances, "cpu", replace(wanted, variation=variation), SEED)
        batch = player.batch
        for _ in range(batch.longest):
            player.decide()
        found = batch.judge.gains.finished.numpy()
        ended = found[:, COMPLETED] > 0.0
        forward = f"{(found[ended, FORWARD] / found[ended, DECISIONS]).mean():.2f}" if ended.any() else ""
        upright = (found[:, DECISIONS] * batch.dt).mean()
        print(f"| {case} | {ended.sum()} of {instances} | {upright:.1f} | {forward} |", flush=True)
        if case == "none" and ended.any():
            earned = found[ended, :COUNT] / (found[ended, DECISIONS, None] * batch.dt)
            custom = batch.judge.gains.custom_finished.numpy()[ended] / (found[ended, DECISIONS, None] * batch.dt)
            rates = [*earned.mean(axis=0), *custom.mean(axis=0)]
            text = ", ".join(f"{name} {rate:.1f}" for name, rate in zip(batch.judge.names, rates, strict=True) if rate)
    if text:
        print(f"\nrewards a second without disturbances: {text}")


if __name__ == "__main__":
    run_script(main)
