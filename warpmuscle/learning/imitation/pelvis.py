"""A pelvis that turns sideways over the gait cycle, with legs below and a trunk above that lean as before."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, multiply, rotate
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.people.pinzone_two import SEARCHED_OBLIQUITY
from warpmuscle.simulation.rollout import Rollout

FORWARD = np.array([0.0, 0.0, 1.0])


def people_obliquity(percent: Floats) -> Floats:
    """How far the left side of people's pelvis is up, rad, at percents of the left foot's cycle, of their shape."""
    return np.radians(SEARCHED_OBLIQUITY.mean(percent))


def obliquity(up: Floats) -> Floats:
    """How far the left side of a root is up, (n,) rad, in which the vertical is (n, 3)."""
    return np.arctan2(up[:, 0], up[:, 1])


def with_obliquity(coordinate: Floats, up: Floats, wanted: Floats, rollout: Rollout) -> tuple[Floats, Floats]:
    """Coordinates and the vertical in the root, whose left side is up by other angles, while all else stays.

    What hangs on the root by ball joints, or by joints of two axes, turns back as far as the root turns.

    Args:
        coordinate: (n, C) of all joints. up: (n, 3). wanted: (n,) rad.
    """
    back = obliquity(up) - wanted
    turned = coordinate.copy()
    for name, joint in rollout.numeric.character.joints.items():
        if joint.parent == rollout.numeric.character.root:
            turn_sideways(name, back, turned, rollout)
    return turned, rotate(about(FORWARD, back), up)


def turn_sideways(name: str, angle: Floats, coordinate: Floats, rollout: Rollout) -> None:
    """Turn a joint about the axis that points forwards by (n,) rad in coordinates (n, C), where it can turn so."""
    joint, body = rollout.numeric.character.joints[name], rollout.names.body_of_joint(name)
    span = slice(rollout.names.coordinate_start[body], rollout.names.coordinate_start[body + 1])
    kind = joint_type(joint)
    if kind.quaternion:
        coordinate[:, span] = multiply(about(FORWARD, angle), coordinate[:, span])
    elif len(kind.coordinates) == 2:
        coordinate[:, span.start + 1] += angle * np.sign(kind.frame(joint)[1][0, 2])
