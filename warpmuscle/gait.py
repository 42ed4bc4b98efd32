"""Speed, step length, width and cadence of a recorded walk."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warpmuscle.pose import about, conjugate, rotate, twist_angle
from warpmuscle.recording import Floats, Integers, Recording

_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Gait:
    """Measures of a walk over a window of time; None where the window holds too few steps to tell."""

    start: float  # s, of the window
    end: float  # s
    speed_forward: float  # m/s, mean velocity of the centre of mass along world z; negative backwards
    speed_horizontal: float  # m/s, magnitude of the mean horizontal velocity
    steps: int  # changes of the stance foot
    step_length: float | None  # m, mean; negative backwards
    step_width: float | None  # m, mean
    cadence: float | None  # steps/min, between the first and the last change
    heading_drift: float  # rad, heading at the end minus heading at the start; positive to the left


def measure(recording: Recording, left_foot: str, right_foot: str, start: float = 5.0) -> Gait:
    """Measure the steady part of a walk.

    A step is the vector between the places of successive stance feet (centres of mass of these bodies, each at the
    moment it becomes the stance foot), in the character's frame at its end: z is its length, |x| its width. These are
    the definitions behind the gait table of the original SIMBICON recordings.

    Args:
        recording: at least one frame; a frame interval of some 10 ms or less.
        left_foot: name of the left foot's body.
        right_foot: name of the right foot's body.
        start: begin of the window, s, so as to skip the transient. If fewer than three changes of stance follow, the
            window begins after a quarter of the recording.

    Raises:
        ValueError: no frames, or an unknown body name.
    """
    if recording.frames == 0:
        raise ValueError("cannot measure the gait of a recording without frames")
    first, last = float(recording.time[0]), float(recording.time[-1])
    fallback = first + 0.25 * (last - first)
    changes = np.flatnonzero(np.diff(recording.stance)) + 1  # first frames of a new stance
    if start > fallback and (start >= last or np.count_nonzero(recording.time[changes] >= start) < 3):
        start = fallback
    steady = recording.time >= start
    velocity = recording.com_velocity[steady].mean(axis=0, dtype=float)
    turned = heading(recording)
    steps = _steps(recording, left_foot, right_foot, turned, changes)[steady[changes]]
    times = recording.time[changes[steady[changes]]].astype(float)
    return Gait(
        start=float(recording.time[steady][0]),
        end=last,
        speed_forward=float(velocity[2]),
        speed_horizontal=math.hypot(velocity[0], velocity[2]),
        steps=len(steps),
        step_length=float(steps[:, 2].mean()) if len(steps) else None,
        step_width=float(np.abs(steps[:, 0]).mean()) if len(steps) else None,
        cadence=60.0 * (len(times) - 1) / float(times[-1] - times[0]) if len(times) > 1 else None,
        heading_drift=float(turned[-1] - turned[steady][0]),
    )


def heading(recording: Recording) -> Floats:
    """Heading (F,) of the root, rad, positive to the left, without jumps."""
    return np.asarray(np.unwrap(twist_angle(recording.root_orientation, _UP)))


def _steps(recording: Recording, left_foot: str, right_foot: str, turned: Floats, changes: Integers) -> Floats:
    """Vectors (K, 3), m, from one stance foot to the next for K changes of stance, in the frame of the heading (F,)."""
    right_stance = recording.stance[:, None] == 1
    stance_foot = np.where(right_stance, recording.position_of(right_foot), recording.position_of(left_foot))
    landings = stance_foot[np.concatenate([[0], changes])].astype(float)
    return rotate(conjugate(about(_UP, turned[changes])), np.diff(landings, axis=0))
