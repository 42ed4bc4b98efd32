"""What the stops of a recorded joint do: the torque of its limits, in float64, from its pose and its motion.

The law is that of `kernels.body.limits`: a one-sided spring-damper about each axis, linearly implicit in the step.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.pose import conjugate, rotate
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Joint, Scene
from warpmuscle.scene.joints import joint_type

LEAST_SINE = 0.2  # between swing and twist of a ball, below which its rates are taken as at this
_EVERY = 1.5  # time steps, up to which frames count as recorded at every one


def stop_torques(recording: Recording, scene: Scene, name: str) -> Floats:
    """Torque (F, 3), N m, of a joint's limits on its parent over the steps that begin with each frame, parent's axes.

    How fast a joint moves over a step is known from its next frame where every step was recorded; else it is the
    recorded rate and half a step of its change between frames.

    Args:
        scene: without free parameters. name: of the joint.
    """
    joint, total = scene.character.joints[name], np.zeros((recording.frames, 3))
    if not joint.limits or recording.frames < 2:
        return total
    step = float(scene.time_step)
    stiffness, damping = first_number(joint.limit_stiffness), first_number(joint.limit_damping)
    every_step = float(np.diff(recording.time).mean()) < _EVERY * step
    for (angle, rate, axis), limits in zip(_about_axes(recording, joint, name), joint.limits, strict=False):
        low, high = map(first_number, limits)
        change = 0.5 * step * np.gradient(rate, recording.time)
        before, over = rate - change, rate + change
        if every_step:
            moved = np.diff(np.unwrap(angle)) / step
            before[1:], over[:-1] = moved, moved
        excess, effective = angle - np.clip(angle, low, high), damping + step * stiffness
        pushes = (stiffness * excess + effective * before) * excess > 0.0  # within the limits, it does not
        total[pushes] += ((stiffness * excess + effective * over)[:, None] * axis)[pushes]
    return total


def _about_axes(recording: Recording, joint: Joint, name: str) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Angle (F,), rad, its rate (F,), rad/s, and where its torque acts (F, 3), parent's axes, of each limited axis."""
    index, kind = recording.joint_names.index(name), joint_type(joint)
    turned = recording.joint_orientation[:, index].astype(float)
    turning = recording.joint_angular_velocity[:, index].astype(float)
    first, second = (np.broadcast_to(axis, turning.shape) for axis in kind.frame(joint))
    if len(joint.limits) == 3:
        for angle, axis in zip(*ball_angles(turned, first, rotate(turned, second)), strict=True):
            yield angle, np.sum(axis * turning, axis=1), axis
        return
    if kind.by_coordinate:
        if name not in recording.coordinate_names:
            return
        coordinate = recording.coordinate[:, recording.coordinate_names.index(name)].astype(float)
        speed = recording.speed[:, recording.speed_names.index(name)].astype(float)
        yield coordinate, speed, rotate(turned, first)
        return
    angles, rates = kind.nearest(joint, turned, turning)
    for k, axis in enumerate((rotate(turned, first), second)[: angles.shape[1]]):
        yield angles[:, k], rates[:, k], axis


def ball_angles(turned: Floats, swing: Floats, twist: Floats) -> tuple[list[Floats], list[Floats]]:
    """Angles (F,) of a ball's rotations about swing, swing x twist and twist, and rows (F, 3) that give their rates.

    Args:
        turned: (F, 4) child in parent. swing: (F, 3) unit axis of the parent; twist: of the child, turned with it.
    """

    def dot(a: Floats, b: Floats) -> Floats:
        return np.asarray(np.sum(a * b, axis=1))

    own_twist = rotate(conjugate(turned), twist)  # in the child, as the parent's in the reference pose
    middle = np.cross(swing, own_twist)
    angles = [
        np.arctan2(dot(middle, twist), dot(own_twist, twist)),
        -np.arcsin(np.clip(dot(swing, twist), -1.0, 1.0)),
        np.arctan2(dot(swing, rotate(turned, middle)), dot(swing, rotate(turned, swing))),
    ]
    across = np.cross(twist, swing)
    length = np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-6)
    between = -across / length
    cosine = np.maximum(length, LEAST_SINE)
    rows = [np.cross(twist, between) / cosine, between, np.cross(between, swing) / cosine]
    return angles, [np.asarray(row) for row in rows]
