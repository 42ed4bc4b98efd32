"""What a gait withstands: pushes of several impulses, slopes, and other speeds at the start, each in one batch.

A run survives that comes to the end of its time without one of the failures of its scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.sequences import rising
from warpmuscle.gait.measures import feet_of, measure
from warpmuscle.simulation.perturbations import none
from warpmuscle.studies.walkers import Walker

IMPULSES = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 80.0)  # N s
PUSHED_FROM, PUSHED_UNTIL, AFTERWARDS = 2.0, 6.0, 4.0  # s, when pushes come, and how long a run goes on after these
_RESAMPLES = 400
_QUANTILES = (0.05, 0.95)


@dataclass(frozen=True, repr=False)
class PushTrials(Tabulated):
    """Which pushes a gait survived.

    Attributes:
        impulses: (L,) N s, ascending; the first is 0. survived: (L, P), of the same P pushes at each impulse.
        direction: (P,) rad from forwards to the left. start: (P,) s.
    """

    impulses: Floats
    survived: NDArray[np.bool_]
    direction: Floats
    start: Floats

    @property
    def half(self) -> float:
        """Impulse that half of the pushes survive, N s; infinite if even the greatest one leaves more, 0 if none."""
        return half_impulse(self.impulses, self.survived.mean(axis=1))

    @property
    def range(self) -> tuple[float, float]:
        """The same for 5 and 95 % of sets of pushes that are drawn again from these."""
        drawn = np.random.default_rng(0).integers(0, len(self.start), (_RESAMPLES, len(self.start)))
        halves = [half_impulse(self.impulses, self.survived[:, chosen].mean(axis=1)) for chosen in drawn]
        low, high = np.quantile(halves, _QUANTILES, method="nearest")
        return float(low), float(high)


@dataclass(frozen=True)
class SlopeTrial:
    """How a gait went on a slope."""

    slope: float  # rad, by which the ground rises forwards
    survived: bool
    end_time: float  # s
    speed: float  # m/s, forwards, of the steady part; horizontal


def push_trials(
    walker: Walker, impulses: Sequence[float] = IMPULSES, pushes: int = 20, *, push_duration: float = 0.1, seed: int = 1
) -> PushTrials:
    """Push the root of a gait at random times from random horizontal directions, at all impulses in one batch.

    Args:
        impulses: N s. pushes: at each of them, the same times and directions. push_duration: s.

    Raises:
        Error: no pushes, or an impulse that is not a positive number.
    """
    levels = np.unique(np.array([0.0, *impulses], dtype=float))
    if pushes < 1 or len(levels) < 2 or not np.all(np.isfinite(levels)) or levels[0] < 0.0:
        raise Error("pushes are one or more, of impulses that are positive numbers (N s)")
    generator = np.random.default_rng(seed)
    direction = generator.uniform(0.0, 2.0 * np.pi, pushes)
    start = generator.uniform(PUSHED_FROM, PUSHED_UNTIL, pushes)
    toward = np.stack([np.sin(direction), 0.0 * direction, np.cos(direction)], axis=1)
    count = len(levels) * pushes
    push = (levels[:, None, None] * toward).reshape(count, 3)
    disturbances = replace(
        none(count), push=push, push_start=np.tile(start, len(levels)), push_duration=push_duration
    )  # fmt: skip
    survived = walker.walk(PUSHED_UNTIL + AFTERWARDS, disturbances).upright
    return PushTrials(levels, survived.reshape(len(levels), pushes), direction, start)


def half_impulse(impulses: Floats, survival: Floats) -> float:
    """Impulse at which the part (L,) that survives falls to one half.

    The parts are first made to fall with the impulse (pooling of neighbours, Ayer 1955); between two impulses they fall
    in a straight line.

    Args:
        impulses: (L,) ascending, N s.

    Returns:
        0 if not even the least impulse leaves half, infinity if the greatest one leaves more than half.
    """
    falling = -rising(-survival)
    below = np.flatnonzero(falling <= 0.5)
    if not len(below):
        return np.inf
    k = int(below[0])
    if k == 0:
        return 0.0
    part = (falling[k - 1] - 0.5) / (falling[k - 1] - falling[k])
    return float(impulses[k - 1] + part * (impulses[k] - impulses[k - 1]))


def slope_trials(walker: Walker, slopes: Sequence[float], duration: float = 20.0) -> list[SlopeTrial]:
    """Let a gait go on slopes, rad, upwards if positive, in one batch."""
    walks = walker.walk(duration, replace(none(len(slopes)), slope=np.array(slopes, dtype=float)), record=True)
    feet = feet_of(walker.scene())
    speeds = [measure(motion, *feet).speed_forward if motion.frames else 0.0 for motion in walks.recordings]
    rows = zip(slopes, walks.upright.tolist(), walks.end_time.tolist(), speeds, strict=True)
    return [SlopeTrial(float(slope), *row) for slope, *row in rows]


def upright(walker: Walker, runs: int = 20, noise: float = 0.05, duration: float = 10.0, *, seed: int = 3) -> int:
    """How many runs of a duration, s, survive whose root starts with noise.

    Args:
        noise: standard deviation in each component of the root's velocity, m/s. seed: that it is drawn with.
    """
    velocity = np.random.default_rng(seed).normal(0.0, noise, (runs, 3))
    return int(walker.walk(duration, replace(none(runs), velocity=velocity)).upright.sum())
