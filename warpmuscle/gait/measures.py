"""Speed, step length, width and cadence of a recorded walk."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from warpmuscle.core.arguments import as_kind, as_number, as_text, in_words
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError, Error, lacking
from warpmuscle.core.pose import about, conjugate, rotate, twist_angle
from warpmuscle.gait.foot_contact import SIDES, touch_downs
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.results.partial_motion import demanding
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.validation.checks import near

CountedBy = Literal["contact", "stance"]
SHORTEST_STRIDE = 0.1  # m, from which on a stride has a direction
_UP = np.array([0.0, 1.0, 0.0])


INSTEAD = {  # of a gait, by names that are often tried
    "speed": "it has speed_forward and speed_horizontal",
    "stride_length": "a stride is two steps: 2 * gait.step_length",
    **dict.fromkeys(("to_dict", "keys", "items"), "dataclasses.asdict(gait) is one"),
    **dict.fromkeys(
        ("cost_of_transport", "cot", "energy", "double_support", "duty_factor", "stance", "stance_time", "swing_time"),
        "save the run as run.h5; `warpmuscle gait run.h5` of the command line measures it",
    ),
}


@dataclass(frozen=True)
class Gait:
    """Measures of a walk over a window of time; None where the window holds too few steps to tell."""

    start: float  # s, of the window
    end: float  # s
    speed_forward: float  # m/s, mean velocity of the centre of mass along world z; negative backwards
    speed_horizontal: float  # m/s, magnitude of the mean horizontal velocity
    steps: int  # from one foot to the other
    step_length: float | None  # m, mean; negative backwards
    step_width: float | None  # m, mean; negative where feet cross
    cadence: float | None  # steps/min, between the first and the last of them
    heading_drift: float  # rad, heading at the end minus heading at the start; positive to the left

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried."""
            raise lacking("a gait", name, dir(self), INSTEAD)


def feet_of(scene: Scene) -> tuple[str, str]:
    """Names of the left and the right foot's body.

    Raises:
        Error: the character has no such bodies.
    """
    feet = scene.feet or ("lFoot", "rFoot")
    if missing := [foot for foot in feet if foot not in scene.character.bodies]:
        lacking = " or ".join(map(repr, missing))
        remedy = "" if scene.feet else "; `character.feet` names feet that are called otherwise"
        raise Error(f"{scene.name} has no legs to walk on: there is no body {lacking}{remedy}")
    return feet


def measure(
    recording: Recording,
    left_foot: str | Scene = "lFoot",
    right_foot: str = "rFoot",
    start: float = 5.0,
    by: CountedBy = "contact",
) -> Gait:
    """Measure the steady part of a walk.

    A step is the vector between the places of the two feet (centres of mass of these bodies, each at the moment it
    touches down, see `foot_contact`). Its length is along the line from the last place of the foot that it ends with to
    the new one; its width is how far the other foot stands from that line, to its own side. So neither depends on how
    the pelvis turns. In place, where there is no such line, the mean heading over both steps takes its place.

    Args:
        recording: at least one frame; a frame interval of some 10 ms or less.
        left_foot: name of the left foot's body, or the scene, whose `character.feet` names both, and on whose treadmill
            places are relative to the belts.
        right_foot: name of the right foot's body.
        start: begin of the window, s, so as to skip the transient. If fewer than three landings follow, the window
            begins after a quarter of the recording.
        by: "stance" counts a step from where the controller makes the other foot its stance foot, whether or not that
            touches the ground, and takes it in the frame of the root's heading at its end, the width without a sign:
            the definition behind the gait table of the original SIMBICON recordings.

    Raises:
        ArgumentError: no frames, or an unknown body name.
        Error: a scene without feet.
    """
    recording = demanding(as_kind(Recording, recording, "recording"), "this recording")
    if isinstance(left_foot, Scene):
        recording = over_belts(recording, left_foot)
        left_foot, right_foot = feet_of(left_foot)
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
    landings = _landings_of(recording, left_foot, right_foot, by)
    times = landings.times
    if start > fallback and (start >= last or np.count_nonzero(times >= start) < 3):
        start = fallback
    steady = recording.time >= start
    velocity = recording.com_velocity[steady].mean(axis=0, dtype=float)
    turned = heading(recording)
    steps = _steps_in_heading(landings, start) if by == "stance" else _steps(landings, start)
    times = times[1:] if by == "stance" else times  # at the start no foot comes down
    times = times[times >= start]
    return Gait(
        start=float(recording.time[steady][0]),
        end=last,
        speed_forward=float(velocity[2]),
        speed_horizontal=math.hypot(velocity[0], velocity[2]),
        steps=len(steps),
        step_length=_mean(steps[:, 0]),
        step_width=_mean(steps[:, 1]),
        cadence=_cadence(times),
        heading_drift=float(turned[-1] - turned[steady][0]),
    )


class Steps(NamedTuple):
    """Steps of a walk in the order of time."""

    sides: Integers  # (K,) of the foot that each ends with: 0 left, 1 right
    lengths: Floats  # (K,) m
    widths: Floats  # (K,) m, NaN where there is no line to measure from

    def of(self, side: int) -> Floats:
        """Lengths of those that end with one foot, m."""
        return np.asarray(self.lengths[self.sides == side])

    @property
    def length_deviation(self) -> float | None:
        """Standard deviation of the length from one step to the next of the same foot, m; None of fewer than three.

        A limp, which makes steps of one foot longer than those of the other, is no variability.
        """
        sides = [self.of(side) for side in (0, 1)]
        if min(map(len, sides)) < 3:
            return None
        return float(np.sqrt(np.mean([np.var(lengths, ddof=1) for lengths in sides])))


def steps_of(recording: Recording, scene: Scene, start: float = 5.0) -> Steps:
    """The steps of a walk from a time on, s, as `measure` counts them.

    Args:
        recording: on a treadmill relative to the belts, see `over_belts`.

    Raises:
        Error: the scene has no feet.
    """
    landings = _landings_of(recording, *feet_of(scene))
    steps = _steps(landings, start)
    return Steps(landings.sides[landings.steps(start)], steps[:, 0], steps[:, 1])


def _cadence(times: Floats) -> float | None:
    """Steps a minute between landings at times (n,), s; None where there are no two, or both feet land at once."""
    if len(times) < 2 or times[-1] == times[0]:
        return None
    return 60.0 * (len(times) - 1) / float(times[-1] - times[0])


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


def _landings_of(recording: Recording, left_foot: str, right_foot: str, by: CountedBy = "contact") -> _Landings:
    """Where the feet of these bodies come down."""
    times, sides = _landings(recording) if by == "contact" else _changes(recording)
    frames = np.minimum(np.searchsorted(recording.time, times), recording.frames - 1)
    feet = np.stack([recording.position_of(left_foot), recording.position_of(right_foot)])
    return _Landings(times, sides, feet[sides, frames].astype(float), heading(recording)[frames])


class _Landings(NamedTuple):
    """Where feet come down, in the order of time."""

    times: Floats  # (L,) s
    sides: Integers  # (L,) 0 left, 1 right
    places: Floats  # (L, 3) m
    headings: Floats  # (L,) rad, of the root

    def steps(self, start: float) -> Integers:
        """Landings that end a step, at or after a time."""
        return np.flatnonzero((self.sides[1:] != self.sides[:-1]) & (self.times[1:] >= start)) + 1


def _steps_in_heading(landings: _Landings, start: float) -> Floats:
    """Lengths and widths (K, 2), m, of steps in the frame of the root's heading where each ends."""
    k = landings.steps(start)
    step = rotate(conjugate(about(_UP, landings.headings[k])), landings.places[k] - landings.places[k - 1])
    return np.stack([step[:, 2], np.abs(step[:, 0])], axis=1)


def _steps(landings: _Landings, start: float) -> Floats:
    """Lengths and widths (K, 2), m, of steps along and across the lines of feet; NaN for widths that have no line."""
    k = landings.steps(start)
    before = np.maximum(k - 2, 0)
    known = (k >= 2) & (landings.sides[before] == landings.sides[k])
    facing = rotate(about(_UP, 0.5 * (landings.headings[k] + landings.headings[k - 1])), np.array([0.0, 0.0, 1.0]))
    stride = (landings.places[k] - landings.places[before]) * [1.0, 0.0, 1.0]
    length = np.linalg.norm(stride, axis=1)
    along = np.where((known & (length > SHORTEST_STRIDE))[:, None], stride / np.maximum(length, 1e-9)[:, None], facing)
    along *= np.where(np.sum(along * facing, axis=1) < 0.0, -1.0, 1.0)[:, None]  # also of who walks backwards
    step = landings.places[k] - landings.places[k - 1]
    outwards = np.where(landings.sides[k - 1] == 0, 1.0, -1.0)  # the left of who faces z is x
    width = -outwards * np.sum(step * np.cross(_UP, along), axis=1)
    return np.stack([np.sum(step * along, axis=1), np.where(known, width, np.nan)], axis=1)


def _mean(values: Floats) -> float | None:
    """Of those that are known."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else None
