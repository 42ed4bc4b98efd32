"""Speed, step length, width and cadence of a recorded walk."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from warpmuscle.core.arguments import as_kind, as_number, as_text, in_words
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.pose import about, conjugate, rotate, twist_angle
from warpmuscle.gait.foot_contact import SIDES, touch_downs
from warpmuscle.results.recording import Recording
from warpmuscle.scene.validation.checks import near

Steps = Literal["contact", "stance"]
_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Gait:
    """Measures of a walk over a window of time; None where the window holds too few steps to tell."""

    start: float  # s, of the window
    end: float  # s
    speed_forward: float  # m/s, mean velocity of the centre of mass along world z; negative backwards
    speed_horizontal: float  # m/s, magnitude of the mean horizontal velocity
    steps: int  # from one foot to the other
    step_length: float | None  # m, mean; negative backwards
    step_width: float | None  # m, mean
    cadence: float | None  # steps/min, between the first and the last of them
    heading_drift: float  # rad, heading at the end minus heading at the start; positive to the left


def measure(recording: Recording, left_foot: str, right_foot: str, start: float = 5.0, by: Steps = "contact") -> Gait:
    """Measure the steady part of a walk.

    A step is the vector between the places of the two feet (centres of mass of these bodies, each at the moment it
    touches down, see `foot_contact`), in the character's frame at its end: z is its length, |x| its width.

    Args:
        recording: at least one frame; a frame interval of some 10 ms or less.
        left_foot: name of the left foot's body.
        right_foot: name of the right foot's body.
        start: begin of the window, s, so as to skip the transient. If fewer than three landings follow, the window
            begins after a quarter of the recording.
        by: "stance" counts a step from where the controller makes the other foot its stance foot, whether or not that
            touches the ground: the definition behind the gait table of the original SIMBICON recordings.

    Raises:
        ArgumentError: no frames, or an unknown body name.
    """
    as_kind(Recording, recording, "recording")
    start = as_number(start, "start")
    for name, foot in (("left_foot", left_foot), ("right_foot", right_foot)):
        if as_text(foot, name) not in recording.body_names:
            raise ArgumentError(f"{name}: no body is called {foot!r}{near(foot, recording.body_names)}")
    if not isinstance(by, str) or by not in ("contact", "stance"):
        raise ArgumentError(f"by must be 'contact' or 'stance', not {in_words(by)}")
    if recording.frames == 0:
        raise ArgumentError("cannot measure the gait of a recording without frames")
    first, last = float(recording.time[0]), float(recording.time[-1])
    fallback = first + 0.25 * (last - first)
    times, sides = _landings(recording) if by == "contact" else _changes(recording)
    if start > fallback and (start >= last or np.count_nonzero(times >= start) < 3):
        start = fallback
    steady = recording.time >= start
    velocity = recording.com_velocity[steady].mean(axis=0, dtype=float)
    turned = heading(recording)
    steps = _steps(recording, left_foot, right_foot, turned, times, sides, start)
    times = times[1:] if by == "stance" else times  # at the start no foot comes down
    times = times[times >= start]
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


def _landings(recording: Recording) -> tuple[Floats, Integers]:
    """Times (K,), s, at which feet touch down, and which ones, 0 left, 1 right."""
    times = [touch_downs(recording, side) for side in SIDES]
    sides = np.repeat([0, 1], [len(of_side) for of_side in times])
    order = np.argsort(np.concatenate(times), kind="stable")
    return np.concatenate(times)[order], sides[order]


def _changes(recording: Recording) -> tuple[Floats, Integers]:
    """Times (K,), s, at which a foot becomes the controller's stance foot, and which ones; the start is the first."""
    frames = np.concatenate([[0], np.flatnonzero(np.diff(recording.stance)) + 1])
    return recording.time[frames].astype(float), recording.stance[frames]


def _steps(
    recording: Recording, left_foot: str, right_foot: str, turned: Floats, times: Floats, sides: Integers, start: float
) -> Floats:
    """Vectors (K, 3), m, from one foot's place to the other's, in the frame of the heading (F,) where a step ends.

    Args:
        times: (L,) s, of landings. sides: (L,) of these. start: s, that steps end at or after.
    """
    frames = np.minimum(np.searchsorted(recording.time, times), recording.frames - 1)
    feet = np.stack([recording.position_of(left_foot), recording.position_of(right_foot)])
    places = feet[sides, frames].astype(float)
    chosen = np.flatnonzero((sides[1:] != sides[:-1]) & (times[1:] >= start)) + 1
    return rotate(conjugate(about(_UP, turned[frames[chosen]])), places[chosen] - places[chosen - 1])
