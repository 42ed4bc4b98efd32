"""A pelvis that turns sideways over the gait cycle, or leans forwards, with legs and a trunk that lean as before."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, multiply, normalized, rotate
from warpmuscle.scene import Joint
from warpmuscle.scene.joints import JointType, joint_type
from warpmuscle.scene.people.pinzone_two import SEARCHED_OBLIQUITY
from warpmuscle.simulation.rollout import Rollout

LEFT, UP, FORWARD = np.eye(3)
AXES = {"sideways": FORWARD, "forwards": LEFT}  # about which a pelvis turns
ALIGNED = 0.5  # cosine between the first axis of a joint and the one to the left, from which it bends forwards


def people_obliquity(percent: Floats) -> Floats:
    """How far the left side of people's pelvis is up, rad, at percents of the left foot's cycle, of their shape."""
    return np.radians(SEARCHED_OBLIQUITY.mean(percent))


def obliquity(up: Floats) -> Floats:
    """How far the left side of a root is up, (n,) rad, in which the vertical is (n, 3)."""
    return np.arctan2(up[:, 0], up[:, 1])


def tilt(up: Floats) -> Floats:
    """How far a root leans forwards, (n,) rad, in which the vertical is (n, 3)."""
    return np.arctan2(-up[:, 2], up[:, 1])


def orientation_of(up: Floats) -> Floats:
    """Quaternions (n, 4) of a root that faces forwards, in which the vertical is (n, 3): the shortest turn."""
    half = np.concatenate([np.cross(up, UP), 1.0 + up[:, 1:2]], axis=1)
    return np.asarray(normalized(half))


def with_obliquity(coordinate: Floats, up: Floats, wanted: Floats, rollout: Rollout) -> tuple[Floats, Floats]:
    """Coordinates and the vertical in the root, whose left side is up by other angles, while all else stays.

    What hangs on the root by ball joints, or by joints of two axes, turns back as far as the root turns.

    Args:
        coordinate: (n, C) of all joints. up: (n, 3). wanted: (n,) rad.
    """
    return _turned("sideways", obliquity(up) - wanted, coordinate, up, rollout)


def with_tilt(coordinate: Floats, up: Floats, wanted: float, rollout: Rollout) -> tuple[Floats, Floats]:
    """Coordinates and the vertical in the root, which leans forwards by another angle, while all else stays.

    What hangs on the root by ball joints, or by joints that bend forwards first, turns back as far as the root turns.

    Args:
        coordinate: (n, C) of all joints. up: (n, 3). wanted: rad.
    """
    return _turned("forwards", tilt(up) - wanted, coordinate, up, rollout)


def _turned(way: str, back: Floats, coordinate: Floats, up: Floats, rollout: Rollout) -> tuple[Floats, Floats]:
    """Joints of the root, and the vertical in it, turned (n,) rad about an axis; the root itself turns against it."""
    turned, turn = coordinate.copy(), turn_sideways if way == "sideways" else turn_forwards
    for name, joint in rollout.numeric.character.joints.items():
        if joint.parent == rollout.numeric.character.root:
            turn(name, back, turned, rollout)
    return turned, rotate(about(AXES[way], back), up)


def turn_sideways(name: str, angle: Floats, coordinate: Floats, rollout: Rollout) -> None:
    """Turn a joint about the axis that points forwards by (n,) rad in coordinates (n, C), where it can turn so."""
    joint, kind, span = _joint(name, rollout)
    if kind.quaternion:
        coordinate[:, span] = multiply(about(FORWARD, angle), coordinate[:, span])
    elif len(kind.coordinates) == 2:
        coordinate[:, span.start + 1] += angle * np.sign(kind.frame(joint)[1][0, 2])


def turn_forwards(name: str, angle: Floats, coordinate: Floats, rollout: Rollout) -> None:
    """Turn a joint about the axis to the left by (n,) rad in coordinates (n, C), where it can turn so."""
    joint, kind, span = _joint(name, rollout)
    if kind.quaternion:
        coordinate[:, span] = multiply(about(LEFT, angle), coordinate[:, span])
    elif span.stop > span.start and not joint.follows:
        along = kind.frame(joint)[0][0, 0]
        if abs(along) > ALIGNED:
            coordinate[:, span.start] += angle * np.sign(along)


def _joint(name: str, rollout: Rollout) -> tuple[Joint, JointType, slice]:
    """A joint, its type, and where its coordinates are."""
    joint, names = rollout.numeric.character.joints[name], rollout.names
    return joint, joint_type(joint), names.coordinates_of(names.body_of_joint(name))
