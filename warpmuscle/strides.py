"""Gait cycles of a recorded walk: from one touch-down of a foot to the next, and curves over them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.errors import Error
from warpmuscle.figure import leg
from warpmuscle.gait import measure
from warpmuscle.norms import FLEXION, LEG_ANGLES
from warpmuscle.pose import twist_angle
from warpmuscle.recording import Floats, Recording
from warpmuscle.scene import Character, Scene

SIDES = ("left", "right")
PERCENT = np.linspace(0.0, 100.0, 101)  # of the gait cycle, where curves have their samples
_TOUCH = 0.05  # of the greatest vertical force: a foot with more is on the ground
_FLIGHT = 0.1  # s, shortest time off the ground before a touch-down
Strides = list[tuple[float, float]]  # s, begin and end of each


def feet_of(scene: Scene) -> tuple[str, str]:
    """Names of the left and the right foot's body.

    Raises:
        Error: the character has no such bodies.
    """
    feet = ("lFoot", "rFoot") if scene.controller is None else scene.controller.feet
    if missing := [foot for foot in feet if foot not in scene.character.bodies]:
        raise Error(f"{scene.name} has no legs to walk on: there is no body {' or '.join(map(repr, missing))}")
    return feet


def touch_downs(recording: Recording, side: str) -> Floats:
    """Times at which a foot, left or right, touches down: it becomes the stance foot, or else takes up force; s."""
    stance, number = recording.stance.astype(int), SIDES.index(side)
    if np.any(np.diff(stance)):
        return recording.time[np.flatnonzero((stance[1:] == number) & (stance[:-1] != number)) + 1].astype(float)
    force = recording[f"foot_force_{side}"][:, 1]
    down = force > _TOUCH * max(float(force.max(initial=0.0)), 1.0)
    rises = np.flatnonzero(down[1:] & ~down[:-1]) + 1
    time = recording.time.astype(float)
    found = [k for k in rises if not np.any(down[(time >= time[k] - _FLIGHT) & (time < time[k])])]
    return time[found]


def strides(recording: Recording, side: str, start: float = 0.0) -> Strides:
    """Whole gait cycles of one side that begin at `start`, s, or later."""
    times = touch_downs(recording, side)
    times = times[times >= start]
    return list(zip(times[:-1].tolist(), times[1:].tolist(), strict=True))


def spans(true: NDArray[np.bool_]) -> list[slice[int, int, None]]:
    """Slices in which an array (F,) is true without a break."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], true.astype(np.int8), [0]])))
    return [slice(int(begin), int(end)) for begin, end in zip(edges[::2], edges[1::2], strict=True)]


def longest_span(true: NDArray[np.bool_]) -> slice[int, int, None] | None:
    """The longest slice in which an array (F,) is true without a break, the first of several; None if it never is."""
    return max(spans(true), key=lambda span: span.stop - span.start, default=None)


def steady_strides(recording: Recording, scene: Scene) -> dict[str, Strides]:
    """Gait cycles of both sides in the steady part of a walk, as `gait.measure` finds it.

    Raises:
        Error: no legs, or fewer than one whole cycle of a side.
    """
    feet = feet_of(scene)
    start = measure(recording, *feet).start if recording.frames else 0.0
    found = {side: strides(recording, side, start) or strides(recording, side) for side in SIDES}
    for side, cycles in found.items():
        if not cycles:
            raise Error(f"the motion of {scene.name} has no whole gait cycle: the {side} foot lands less than twice")
    return found


def over_strides(time: Floats, values: NDArray[Any], cycles: Strides) -> Floats:
    """Curves (S, 101, ...) over each of S gait cycles, linearly interpolated from values (F, ...) at times (F,)."""
    at = np.array([begin + (end - begin) * PERCENT / 100.0 for begin, end in cycles])  # (S, 101)
    clock = np.asarray(time, dtype=float)
    after = np.clip(np.searchsorted(clock, at), 1, len(clock) - 1)
    part = np.clip((at - clock[after - 1]) / (clock[after] - clock[after - 1]), 0.0, 1.0)
    part = part.reshape(part.shape + (1,) * (values.ndim - 1))
    return np.asarray((1.0 - part) * values[after - 1] + part * values[after])


def leg_angles(recording: Recording, scene: Scene) -> dict[str, dict[str, Floats]]:
    """Sagittal angles (F,), degrees, of hip, knee and ankle, by name and side; flexion is positive.

    Raises:
        Error: no legs, or legs of fewer than three joints.
    """
    found: dict[str, dict[str, Floats]] = {name: {} for name in LEG_ANGLES}
    for side, foot in zip(SIDES, feet_of(scene), strict=True):
        joints = leg(scene.character, foot)[-3:]
        if len(joints) < 3:
            raise Error(f"{scene.name} has no hip, knee and ankle: {len(joints)} joints lead to its {side} foot")
        for name, joint, sign in zip(LEG_ANGLES, joints, FLEXION, strict=True):
            found[name][side] = np.degrees(sign * sagittal_angle(recording, joint))
    return found


def vertical_forces(recording: Recording, scene: Scene) -> dict[str, Floats]:
    """Vertical ground forces (F,) on the feet over the weight of a numeric scene's character, by side."""
    weight = body_weight(scene)
    return {side: recording[f"foot_force_{side}"][:, 1] / weight for side in SIDES}


def sagittal_angle(recording: Recording, joint: str) -> Floats:
    """Turn (F,) of a joint's child about x, rad, without jumps."""
    orientation = recording.joint_orientation[:, recording.joint_names.index(joint)]
    return np.unwrap(twist_angle(orientation, (1.0, 0.0, 0.0)))


def body_mass(character: Character) -> float:
    """Mass of a numeric character, kg."""
    return float(sum(float(np.asarray(body.mass).flat[0]) for body in character.bodies.values()))


def body_weight(scene: Scene) -> float:
    """Weight of a numeric scene's character, N; at least a tiny one, so that it can be divided by."""
    return max(body_mass(scene.character) * abs(float(np.asarray(scene.gravity).flat[0])), 1e-9)
