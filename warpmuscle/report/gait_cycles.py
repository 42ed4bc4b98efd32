"""Gait cycles of recorded trials, by the plates under the feet."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.inverse.body_model import BodyLoads
from warpmuscle.inverse.output import Trial

LOADED = 30.0  # N, upon a foot that stands
LEAST, MOST = 0.4, 3.0  # s, that a stride takes


class RecordedTrial(NamedTuple):
    """A trial with what its page needs besides."""

    found: Trial
    times: Floats  # (n,) s, of the forces on bodies
    loads: BodyLoads  # (n, ...) world axes
    sides: tuple[str, ...]  # of each load: left, right, or nothing
    emg: dict[str, tuple[Floats, Floats]]  # times and envelopes by muscle, if any was measured


class Cycle(NamedTuple):
    """A stride of a side, s."""

    side: str
    begin: float
    end: float


def side_of(name: str) -> str:
    """`left` or `right` of a name such as `calcn_r`, `r_foot` or `knee_angle_l`; nothing for others."""
    words = name.lower().replace("-", "_").split("_")
    for letter, side in (("r", "right"), ("l", "left")):
        if letter in words or side in name.lower():
            return side
    return ""


def cycles_of(trial: RecordedTrial) -> list[Cycle]:
    """Strides from each contact of a foot to its next."""
    found = []
    for side in ("left", "right"):
        own = [k for k, other in enumerate(trial.sides) if other == side]
        if not own:
            continue
        down = trial.loads.force[:, own, 1].sum(axis=1) > LOADED
        landed = trial.times[1:][down[1:] & ~down[:-1]]
        found += [Cycle(side, float(a), float(b)) for a, b in itertools.pairwise(landed) if LEAST < b - a < MOST]
    return found


def over_cycle(times: Floats, values: Floats, cycle: Cycle) -> Floats | None:
    """Values (101,) over a stride; None where they do not reach over it."""
    slack = 0.02 * (cycle.end - cycle.begin)
    if len(times) < 2 or times[0] > cycle.begin + slack or times[-1] < cycle.end - slack:
        return None
    return np.interp(cycle.begin + 0.01 * PERCENT * (cycle.end - cycle.begin), times, values)
