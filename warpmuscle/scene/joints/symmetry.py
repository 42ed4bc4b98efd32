"""What is whose image in a mirror at the plane x = 0 of a body: by names of left and right, and by how joints turn."""

from __future__ import annotations

import itertools
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Character, Joint
from warpmuscle.scene.joints import JointType, joint_type

SIDES = (("l", "r"), ("left", "right"), ("L", "R"), ("Left", "Right"))
VECTOR = np.array([-1.0, 1.0, 1.0])  # of x, y, z of a place, a velocity, a force
TURN = np.array([1.0, -1.0, -1.0])  # of x, y, z of a turn, an angular velocity, a torque
QUATERNION = np.array([1.0, -1.0, -1.0, 1.0])
ALIKE = 1e-4  # rad or m, that two sides may differ by


def counterpart(name: str, names: Collection[str]) -> str:
    """Name of what is on the other side: `rHAM` for `lHAM`, `ham_r` for `ham_l`, ...; empty if there is none."""
    return _side_and_counterpart(name, names)[1]


def side_of(name: str, names: Collection[str]) -> str:
    """Which side something is on, "left" or "right", by its name; empty if nothing is its counterpart."""
    return _side_and_counterpart(name, names)[0]


def _side_and_counterpart(name: str, names: Collection[str]) -> tuple[str, str]:
    for left, right in SIDES:
        for side, own, other in (("left", left, right), ("right", right, left)):
            for candidate in (
                other + name.removeprefix(own) if name.startswith(own) else "",
                name.removesuffix(f"_{own}") + f"_{other}" if name.endswith(f"_{own}") else "",
                name.replace(f"_{own}_", f"_{other}_"),  # a patella's knee_angle_r_beta
            ):
                if candidate in names and candidate != name:
                    return side, candidate
    return "", ""


class JointImage(NamedTuple):
    """The joint that is another one's image, and signs of its coordinates and speeds there."""

    name: str
    coordinates: Floats
    speeds: Floats


def joint_image(character: Character, name: str) -> JointImage:
    """The image of a joint of a numeric character: its counterpart, or itself where it has none.

    Raises:
        SceneError: the two do not move as images of each other.
    """
    joints = character.joints
    other = counterpart(name, joints) or name
    mine, theirs = joint_type(joints[name]), joint_type(joints[other])
    if mine is theirs:
        if mine.quaternion:
            return JointImage(other, QUATERNION, TURN)
        if joints[name].follows:  # its coordinates are those of one or two other joints
            drivers, others = _drivers(joints[name]), _drivers(joints[other])
            images = [joint_image(character, driver) for driver in drivers]
            together = np.concatenate([image.coordinates for image in images])
            if [image.name for image in images] == others and _alike(mine, joints[name], joints[other], together):
                return JointImage(other, np.zeros(0), np.zeros(0))
            raise _no_image(name, other)
        for signs in itertools.product((1.0, -1.0), repeat=len(mine.speeds)):
            if _alike(mine, joints[name], joints[other], np.array(signs)):
                return JointImage(other, np.array(signs), np.array(signs))
    raise _no_image(name, other)


def _drivers(joint: Joint) -> list[str]:
    """The joints that a joint follows."""
    return [driver for driver in (joint.follows, joint.beside) if driver]


def _no_image(name: str, other: str) -> SceneError:
    """The error of a joint that does not move as another one in a mirror, or as itself."""
    said = f"does not move as the mirror image of {other!r} does" if other != name else "is not its own mirror image"
    return SceneError(said, key=f"character.joints.{name}")


def check_muscles(character: Character) -> None:
    """Raise SceneError unless muscles of a numeric character are as strong and as long as their counterparts."""
    muscles = character.muscles
    for name, one in muscles.items():
        other = counterpart(name, muscles) or name
        if any(getattr(one, part) != getattr(muscles[other], part) for part in ("f_max", "l_opt", "l_slack")):
            raise SceneError(f"is not like its image {other!r}", key=f"character.muscles.{name}")


def is_symmetric(character: Character) -> bool:
    """Whether the joints and muscles of a numeric character are their own images, some of them on another side."""
    joints = character.joints
    try:
        images = {name: joint_image(character, name).name for name in joints}
        check_muscles(character)
    except SceneError:
        return False
    return any(name != image for name, image in images.items())


def _alike(kind: JointType, mine: Joint, theirs: Joint, signs: Floats) -> bool:
    """Whether the poses of one joint are images of those of another whose coordinates have these signs."""
    random = np.random.default_rng(0)
    q = random.uniform(-0.5, 0.5, (8, len(signs)))
    one, other = (kind.motion(joint, values, np.zeros_like(q)) for joint, values in ((mine, q), (theirs, q * signs)))
    turned = np.abs(np.sum(one.orientation * QUATERNION * other.orientation, axis=1))
    angle = 2.0 * np.arccos(np.minimum(turned, 1.0))
    away = np.abs(one.place * VECTOR - other.place)
    return bool(angle.max() < ALIKE and away.max() < ALIKE)
