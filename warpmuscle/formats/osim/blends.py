"""Conditional points that would let a path jump as they come in at once: they come in over a narrow band instead."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Condition, JointState, Muscle, Scene
from warpmuscle.scene.initial_pose import initial_pose, plain_number, plain_vector
from warpmuscle.scene.joints import joint_type

JUMP = 4.0e-3  # m, that a path may change by at once
BAND = 4.0  # rad of the band for each metre of the jump: the slope of the length is 0.4 m within it
NARROWEST, WIDEST = 0.01, 0.2  # rad
LEANING = 0.1  # rad or m, by which a joint that leans on a stop may be beyond it
OPEN = 1.0  # rad or m beyond the stop, where conditions end that shall not end at all


def blend_conditions(scene: Scene) -> dict[str, float]:
    """Give conditions a `blend` where a point that comes in at once would move a path by more than `JUMP`.

    The slope of the length is no moment arm there: a moving joint would be thrown about by it. It is left out, and the
    moment arms lie between OpenSim's before the jump and after it.

    Paths that wrap or move cannot be blended, nor those over ball joints: this comes before hinges are merged.

    Returns:
        By how much paths would jump, m, by muscle, in the initial pose but for the coordinate of the condition.
    """
    found: dict[str, float] = {}
    for name, muscle in scene.character.muscles.items():
        if any(point.motion for point in muscle.path):
            continue
        jumps = [_jump(scene, muscle, k) if point.condition else 0.0 for k, point in enumerate(muscle.path)]
        if max(jumps, default=0.0) <= JUMP:
            continue
        found[name] = max(jumps)
        for point, jump in zip(muscle.path, jumps, strict=True):
            if point.condition is not None and not muscle.wraps:
                point.condition.blend = round(min(max(BAND * jump, NARROWEST), WIDEST), 3)
                point.condition.moment_arms = "weighted"
    return found


def open_at_stops(scene: Scene) -> None:
    """Let conditions go on that end with their coordinate's range, or a little beyond it.

    A joint may lean on its stop, and a path would jump there: those of gait2392 by 7 mm at a knee extended by 10
    degrees. Within the range nothing changes.
    """
    for muscle in scene.character.muscles.values():
        for point in muscle.path:
            condition = point.condition
            joint = scene.character.joints.get(condition.joint) if condition is not None else None
            if condition is None or joint is None or not joint.limits:  # no joint: told of later
                continue
            low, high = (plain_number(end) for end in joint.limits[condition.axis])
            if 0.0 <= low - plain_number(condition.low) <= LEANING:
                condition.low = round(low - OPEN, 6)
            if 0.0 <= plain_number(condition.high) - high <= LEANING:
                condition.high = round(high + OPEN, 6)


def _jump(scene: Scene, muscle: Muscle, number: int) -> float:
    """By how much a point makes a path longer at the ends of its condition, m, the greater of both."""
    condition = muscle.path[number].condition
    assert condition is not None
    joint, found = scene.character.joints[condition.joint], 0.0
    low, high = (plain_number(end) for end in joint.limits[0]) if joint.limits else (-math.pi, math.pi)
    for end in (plain_number(condition.low), plain_number(condition.high)):
        if low <= end <= high:
            places, counted = _posed(scene, muscle, condition, end)
            through = [place for k, place in enumerate(places) if counted[k] or k == number]
            past = [place for k, place in enumerate(places) if counted[k] and k != number]
            found = max(found, abs(_length(through) - _length(past)))
    return found


def _posed(scene: Scene, muscle: Muscle, condition: Condition, end: float) -> tuple[list[Floats], list[bool]]:
    """Places of a path's points, m, and which of them count, where a condition's coordinate is at one end."""
    joint = scene.character.joints[condition.joint]
    x, y, z, w = map(float, joint_type(joint).turned(joint, np.array([[end]]))[0])
    there = JointState(coordinate=end) if joint_type(joint).by_coordinate else JointState((x, y, z, w))
    joints = scene.initial_state.joints | {condition.joint: there}
    poses, angles = initial_pose(replace(scene, initial_state=replace(scene.initial_state, joints=joints)))
    places: list[Floats] = []
    counted: list[bool] = []
    for point in muscle.path:
        position, orientation = poses[point.body]
        places.append(np.asarray(position + rotate(orientation, plain_vector(point.place()))))
        own = point.condition
        at = float(np.atleast_1d(angles[own.joint])[own.axis]) if own is not None else 0.0
        counted.append(own is None or plain_number(own.low) <= at <= plain_number(own.high))
    return places, counted


def _length(places: Sequence[Floats]) -> float:
    return sum(float(np.linalg.norm(b - a)) for a, b in itertools.pairwise(places))
