"""Corrects how fast a policy goes for a commanded speed: it stretches what the policy observes of the command.

    python tools/calibrate_speed.py run.h5 -o calibrated.h5 --share 0.6

A policy is played at speeds evenly over its range. A line fitted to how fast it went says what it has to be told to go
as fast as it is told, and this `share` of the correction is taken into the scaling of the one number that it observes
of the command. All weights stay as they were learnt. Beyond speeds that it has learnt, likeness suffers.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.formats import toml
from warpmuscle.learning.player import task_of
from warpmuscle.results.learned import Ancestor, PolicyTable
from warpmuscle.results.result import read, write
from warpmuscle.simulation.perturbations import none
from warpmuscle.studies.walkers import PolicyWalker

OBSERVED = "command.speed"
SPEEDS, DURATION, SETTLED = 12, 10.0, 2.0  # of them; s, of each, and until a speed counts


def correction(told: Floats, went: Floats, share: float) -> tuple[float, float]:
    """Factor and offset, m/s, on the speed that is told, for this share of what brings `went` to `told` (n,)."""
    slope, level = np.polyfit(told, went, 1)
    if not slope > 0.0:
        raise Error("it does not go faster when it is told to")
    return 1.0 + share * (1.0 / float(slope) - 1.0), -share * float(level / slope)


def stretched(policy: PolicyTable, factor: float, offset: float) -> PolicyTable:
    """The policy, which takes a speed for this factor times it and the offset, m/s."""
    if OBSERVED not in policy.observation:
        raise Error("the policy observes no speed that is wanted")
    place = policy.observation.index(OBSERVED)
    mean, deviation = policy.mean.copy(), policy.deviation.copy()
    mean[place] = (mean[place] - offset) / factor
    deviation[place] /= factor
    return replace(policy, mean=mean, deviation=deviation)


def calibrate(source: Path, output: Path, share: float, device: str | None, threads: int | None) -> None:
    """Play, correct, play again, and write the policy."""
    result = read(source, replay=0)
    if result.learned is None:
        raise Error(f"{source}: holds no policy")
    if not output.resolve().parent.is_dir():
        raise Error(f"{output}: there is no such folder")
    learned, scene = result.learned, toml.loads(result.scene)
    low, high = task_of(learned).speed
    told = np.linspace(low, high, SPEEDS)

    def speeds(policy: PolicyTable) -> Floats:
        walker = PolicyWalker(replace(learned, policy=policy), scene, device, threads)
        walks = walker.walk(DURATION, none(SPEEDS), {"speed": told}, record=True)
        if not walks.upright.all():
            raise Error(f"told {told[~walks.upright][0]:.2f} m/s, it falls")
        return np.array([one.com_velocity[one.time >= SETTLED, 2].mean() for one in walks.recordings])

    before = speeds(learned.policy)
    factor, offset = correction(told, before, share)
    policy = stretched(learned.policy, factor, offset)
    after = speeds(policy)
    print(f"takes a speed for {factor:.4f} times it {'+' if offset > 0 else '-'} {abs(offset):.4f} m/s")
    for one in zip(told, before, after, strict=True):
        print("told {:.2f} m/s: {:.2f}, now {:.2f}".format(*one))
    itself = Ancestor(source.name, result.seed, learned.decisions, result.command)
    changed = replace(learned, policy=policy, options={"share": share}, ancestors=(itself, *learned.ancestors))
    command = shlex.join(["python", *sys.argv])
    write(output, replace(result, command=command, learned=changed, replays=()))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path)
    parser.add_argument("--output", "-o", type=Path, required=True)
    parser.add_argument("--share", type=float, default=1.0, help="of the correction that is made")
    parser.add_argument("--device")
    parser.add_argument("--threads", type=int)
    given = parser.parse_args()
    try:
        calibrate(given.source, given.output, given.share, given.device, given.threads)
    except Error as error:
        raise SystemExit(f"error: {error}") from None
