"""Gait cycles of a recorded walk: from one contact of a foot with the ground to its next, and curves over them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import conjugate, multiply, twist_angle
from warpmuscle.core.sequences import at_moments
from warpmuscle.gait.foot_contact import SIDES, touch_downs
from warpmuscle.gait.measures import feet_of, measure
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Joint, Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.ground import LIFTED
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.norms import FLEXION, LEG_ANGLES

ALONG_X = 0.7  # least component of an axis along x for which a turn about it is flexion
SMALL = 0.01  # rad, of a turn that shows its axis
NO_CYCLE = "has no whole gait cycle"  # of a motion that cannot be measured as a gait, with its name before
PERCENT = np.linspace(0.0, 100.0, 101)  # of the gait cycle, where curves have their samples
Strides = list[tuple[float, float]]  # s, begin and end of each


def strides(recording: Recording, side: str, start: float = 0.0, weight: float | None = None) -> Strides:
    """Whole gait cycles of one side that begin at `start`, s, or later; `weight`: see `foot_contact.contacts_of`."""
    times = touch_downs(recording, side, weight)
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
    """Gait cycles of both sides in the steady part of a walk, as `measures.measure` finds it.

    Raises:
        Error: no legs, or fewer than one whole cycle of a side.
    """
    feet = feet_of(scene)
    start = measure(recording, *feet).start if recording.frames else 0.0
    weight = body_weight(scene)
    found = {side: strides(recording, side, start, weight) or strides(recording, side, 0.0, weight) for side in SIDES}
    for side, cycles in found.items():
        if not cycles:
            landed = f"the {side} foot lands less than twice, after {LIFTED:g} s off the ground or more"
            raise Error(f"the motion of {scene.name} {NO_CYCLE}: {landed}")
    return found


def over_strides(time: Floats, values: NDArray[Any], cycles: Strides) -> Floats:
    """Curves (S, 101, ...) over each of S gait cycles, linearly interpolated from values (F, ...) at times (F,)."""
    return at_moments(time, values, np.array([begin + (end - begin) * PERCENT / 100.0 for begin, end in cycles]))


def leg_angles(recording: Recording, scene: Scene) -> dict[str, dict[str, Floats]]:
    """Sagittal angles (F,), degrees, of hip, knee and ankle, by name and side; flexion is positive.

    Raises:
        Error: no legs, or legs of fewer than three joints.
    """
    found: dict[str, dict[str, Floats]] = {name: {} for name in LEG_ANGLES}
    feet_of(scene)
    for number, side in enumerate(SIDES):
        joints = leg_joints(scene, number)
        if len(joints) < 3:
            lead = number_of(len(joints), "joint")
            raise Error(f"{scene.name} has no hip, knee and ankle: {lead} on the way to its {side} foot")
        for name, joint, sign in zip(LEG_ANGLES, joints, FLEXION, strict=True):
            found[name][side] = np.degrees(sign * sagittal_angle(recording, joint))
    return found


def flexion_signs(scene: Scene) -> dict[str, float]:
    """Which sign makes a turn about x, or about the first axis, flexion: of the hips, knees and ankles of a scene.

    Figures and plots show angles of these joints with it, so that dorsiflexion is positive in all of them.
    """
    signs: dict[str, float] = {}
    for number in range(len(SIDES)):
        joints = leg_joints(scene, number)
        for name, sign in zip(joints, FLEXION, strict=True) if len(joints) == 3 else ():
            joint = scene.character.joints[name]
            along = along_x(joint)
            if abs(along) > ALONG_X:
                signs[name] = sign * float(np.sign(along))
    return signs


def along_x(joint: Joint) -> float:
    """The part along x of what a joint turns about, of its first axis, for greater angles."""
    kind = joint_type(joint)
    if kind.quaternion:
        return 1.0
    if joint.axes:
        return first_number(joint.axes[0][0])
    if not kind.angles or kind.unit(joint) != "rad":
        return 0.0
    angles = np.zeros((2, len(kind.angles)))
    angles[1, 0] = SMALL
    still, bent = kind.turned(joint, angles)
    return float(2.0 * multiply(bent, conjugate(still))[0] / SMALL)


def sagittal_angle(recording: Recording, joint: str) -> Floats:
    """Turn (F,) of a joint's child about x, rad, without jumps."""
    orientation = recording.joint_orientation[:, recording.joint_names.index(joint)]
    return np.unwrap(twist_angle(orientation, (1.0, 0.0, 0.0)))


def body_weight(scene: Scene) -> float:
    """Weight of a numeric scene's character, N; at least a tiny one, so that it can be divided by."""
    return max(body_mass(scene.character) * abs(first_number(scene.gravity)), 1e-9)
