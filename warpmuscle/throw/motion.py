"""Recorded motions: angles of joints over time, resampled and differentiated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from warpmuscle.core.array_types import Floats

RATE = 100.0  # Hz, of everything that is compared
MARGIN = 0.05  # s, by which a motion is continued beyond both ends
TREND, TREND_SAMPLES, TREND_DEGREE = 0.06, 5, 3  # s and least samples of the end that the polynomial there is fitted to
STILL, LEAST_STILL = 2e-3, 0.1  # rad/s of all angles; s at an end, beyond which stillness is left out
PITCH, PLACE = "trunk_pitch", ("shoulder_forward", "shoulder_up")  # names of what may be absent


@dataclass(frozen=True)
class ArmMotion:
    """A recorded motion as it was read: angles (S, J), rad, at increasing times (S,) from 0 on, s."""

    name: str
    start: float  # s, time of the first sample in its file
    time: Floats
    angles: Floats
    pitch: Floats  # (S,) of the trunk, forwards, rad
    place: Floats  # (S, 2) of the shoulder, forwards and up, m
    absent: tuple[str, ...] = ()  # columns that its file does not have and that count as 0: PITCH, PLACE
    bridged: int = 0  # values that its file lacks, and that are interpolated
    cut: float = 0.0  # s at its ends in which nothing moves, and that were left out


@dataclass(frozen=True)
class ArmMotions:
    """n motions resampled to the same times, t = 0 at their starts; beyond its end a motion comes to rest.

    Each of `angles` (n, T, J), `pitch` (n, T) and `place` (n, T, 2) is followed by its first and second derivative in
    the tuple of the same name.
    """

    names: tuple[str, ...]
    time: Floats  # (T,) s
    valid: Floats  # (n, T) 1 where a motion has data, else 0
    angles: tuple[Floats, Floats, Floats]
    pitch: tuple[Floats, Floats, Floats]
    place: tuple[Floats, Floats, Floats]
    recorded: tuple[ArmMotion, ...]  # what they were resampled from

    def __len__(self) -> int:
        return len(self.names)

    def rows(self, which: Sequence[int]) -> ArmMotions:
        """Some of them."""
        index = list(which)

        def pick(parts: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats, Floats]:
            return parts[0][index], parts[1][index], parts[2][index]

        names, recorded = tuple(self.names[i] for i in index), tuple(self.recorded[i] for i in index)
        return ArmMotions(
            names, self.time, self.valid[index], pick(self.angles), pick(self.pitch), pick(self.place), recorded
        )


def without_stillness(motion: ArmMotion) -> ArmMotion:
    """A motion without what only repeats its first or its last values, as recordings are made equally long.

    Nothing can be learnt there, and a motion that stops within a sample takes more torque than any arm has.
    """
    values = np.column_stack([motion.angles, motion.pitch])
    moves = np.flatnonzero(np.abs(np.diff(values, axis=0)).max(axis=1) > STILL * np.diff(motion.time))
    if not len(moves):
        return motion
    first, last = int(moves[0]), int(moves[-1]) + 1
    first = first if motion.time[first] >= LEAST_STILL else 0
    last = last if motion.time[-1] - motion.time[last] >= LEAST_STILL else len(motion.time) - 1
    time, kept = motion.time[first : last + 1], slice(first, last + 1)
    return replace(
        motion, start=motion.start + float(time[0]), time=time - time[0], angles=motion.angles[kept],
        pitch=motion.pitch[kept], place=motion.place[kept], cut=float(motion.time[-1] - (time[-1] - time[0])),
    )  # fmt: skip


def resample(
    motions: Sequence[ArmMotion], rate: float = RATE, until: float | None = None, margin: float = 0.0
) -> ArmMotions:
    """Motions at the same times from quintic splines, whose first two derivatives are smooth up to the ends.

    Args:
        until: s, at which the times end; by default with the longest motion.
        margin: s, at most `MARGIN`, by which the times begin before 0 and end later.
    """
    longest = max(motion.time[-1] for motion in motions) if until is None else until
    before = int(np.floor(margin * rate + 1e-6))
    time = np.arange(-before, int(np.floor(longest * rate + 1e-6)) + 1 + before) / rate
    shape = (len(motions), len(time))
    valid = np.zeros(shape)
    joints = motions[0].angles.shape[1]
    angles, place = (tuple(np.zeros((*shape, k)) for _ in range(3)) for k in (joints, 2))
    pitch = tuple(np.zeros(shape) for _ in range(3))
    for row, motion in enumerate(motions):
        valid[row] = (time >= 0.0) & (time <= motion.time[-1] + 1e-9)
        for source, target in ((motion.angles, angles), (motion.pitch, pitch), (motion.place, place)):
            for part, values in zip(target, _coming_to_rest(motion.time, source, time), strict=True):
                part[row] = values
    names = tuple(motion.name for motion in motions)
    return ArmMotions(
        names, time, valid, (angles[0], angles[1], angles[2]), (pitch[0], pitch[1], pitch[2]),
        (place[0], place[1], place[2]), tuple(motions),
    )  # fmt: skip


def _coming_to_rest(samples: Floats, values: Floats, time: Floats) -> tuple[Floats, Floats, Floats]:
    """Values and two derivatives at some times (T,); beyond the end time slows down to a halt, without a jump.

    A jump there would ring in a spline through what comes out, and so be seen before the end as well.
    """
    end = samples[-1]
    late = np.maximum(time - end, 0.0) / MARGIN
    pace = 1.0 / np.cosh(np.minimum(late, 300.0)) ** 2
    shape = (-1, *(1 for _ in values.shape[1:]))
    slowing = (-2.0 / MARGIN * np.tanh(late) * pace).reshape(shape)
    pace = pace.reshape(shape)
    curve = _spline(samples, values)
    value, rate, bend = (
        curve(np.where(time > end, end + MARGIN * np.tanh(late), time), nu=order) for order in range(3)
    )
    return value, rate * pace, bend * pace**2 + rate * slowing


def _spline(time: Floats, values: Floats) -> Any:
    """A quintic spline through values (S, ...), continued beyond both ends by the cubic that suits the samples there.

    Ends of a spline with nothing beyond magnify noise; point reflection there, or a natural end, makes accelerations
    vanish that do not, and so torques that nobody needed.
    """
    before, after = (_beyond(time, values), _beyond(-time[::-1], values[::-1]))
    times = np.concatenate([before[0], time, -after[0][::-1]])
    return make_interp_spline(times, np.concatenate([before[1], values, after[1][::-1]]), k=5)


def _beyond(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Times and values before the first sample, by a cubic through it that is nearest to the samples after it."""
    count = max(int(np.sum(time <= time[0] + TREND + 1e-9)), min(TREND_SAMPLES, len(time)))
    step = (time[count - 1] - time[0]) / (count - 1)
    later = np.arange(-int(np.ceil(MARGIN / step + 1e-9)) - 2, 0) * step

    def powers(t: Floats) -> Floats:
        return np.asarray((t[:, None] / TREND) ** np.arange(1, TREND_DEGREE + 1))

    rows = (values - values[0]).reshape(len(values), -1)
    found = np.linalg.lstsq(powers(time[:count] - time[0]), rows[:count], rcond=None)[0]
    return time[0] + later, values[0] + (powers(later) @ found).reshape(-1, *values.shape[1:])
