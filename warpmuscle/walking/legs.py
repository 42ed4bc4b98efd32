"""The legs of a model that names no feet: the chains of bodies that come lowest on either side."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import rotate
from warpmuscle.scene import Character, InitialState, Scene
from warpmuscle.scene.anatomy import leg
from warpmuscle.scene.initial_pose import Poses, plain_vector, world_poses
from warpmuscle.scene.joints.symmetry import side_of

ANKLE_REGION = 0.2  # of a leg's height: joints that lie so close to its lowest one are joints of the foot
LONG_BONE = 0.1  # of a leg's length, from one joint of the foot to the next: the bone that carries the heel
THIGH_AND_SHANK = 0.491  # of a person's height (Winter 2009, fig. 4.1)


class Leg(NamedTuple):
    """A leg in the reference pose."""

    foot: str  # the body that stands on its heel
    toes: str  # the body that hangs on the foot; empty if there is none
    ankle: Floats  # (3,) m, world
    length: float  # m, from hip to ankle along the bones

    def height(self) -> float:
        """How tall a person with such a leg is, m."""
        return self.length / THIGH_AND_SHANK


def in_reference_pose(scene: Scene) -> Scene:
    """The scene with all coordinates at zero and an upright root at the origin."""
    return replace(scene, initial_state=InitialState())


def find_legs(scene: Scene) -> tuple[Leg, Leg]:
    """The left leg and the right of a checked scene without free parameters, in its reference pose.

    Raises:
        SceneError: on one side there is no leg with hip, knee and ankle.
    """
    character, poses = scene.character, world_poses(scene)
    feet = character.feet
    left, right = (
        _leg(character, poses, side, "" if feet is None else feet[number])
        for number, side in enumerate(("left", "right"))
    )
    return left, right


def joint_anchor(character: Character, poses: Poses, joint: str) -> Floats:
    """Where a joint is, m, world: the place on its child that it moves."""
    place, turn = poses[character.joints[joint].child]
    return np.asarray(place + rotate(turn, plain_vector(character.joints[joint].position_in_child)))


def _leg(character: Character, poses: Poses, side: str, foot: str) -> Leg:
    """The leg on one side, down to the foot that the scene names, or to the lowest joint."""
    joints = leg(character, foot or _lowest(character, poses, side))
    places = [joint_anchor(character, poses, name) for name in joints]
    heights = np.array([place[1] for place in places])
    reach = heights[0] - heights[-1]
    below = [k for k in range(len(joints)) if heights[k] - heights[-1] <= ANKLE_REGION * reach]
    if reach <= 0.0 or not below or below[0] < 2:
        raise SceneError(
            f"no leg with hip, knee and ankle was found on the {side}; name the feet, such as "
            'feet = ["foot_l", "foot_r"]',
            key="character.feet",
        )
    first = below[0]
    length = float(np.sum(np.linalg.norm(np.diff(places[: first + 1], axis=0), axis=1)))
    bodies = [character.joints[name].child for name in joints[first:]]
    if foot:
        children = [joint.child for joint in character.joints.values() if joint.parent == foot]
        return Leg(foot, children[0] if children else "", places[first], length)
    long = _longest(places[first:], length)
    return Leg(bodies[long], bodies[long + 1] if long + 1 < len(bodies) else "", places[first], length)


def _longest(places: list[Floats], leg: float) -> int:
    """Number of the bone of a foot that reaches farthest to the next joint, or of the last one if none reaches far."""
    reaches = [float(np.linalg.norm(after - before)) for before, after in itertools.pairwise(places)]
    return int(np.argmax(reaches)) if reaches and max(reaches) >= LONG_BONE * leg else len(places) - 1


def _lowest(character: Character, poses: Poses, side: str) -> str:
    """The body on one side, of those that carry no other, whose joint is lowest, by the names of bodies.

    Raises:
        SceneError: no body is on that side.
    """
    parents = {joint.parent for joint in character.joints.values()}
    heights = {
        joint.child: float(joint_anchor(character, poses, name)[1])
        for name, joint in character.joints.items()
        if joint.child not in parents and side_of(joint.child, character.bodies) == side
    }
    if not heights:
        said = f"no body is called one of the {side}, such as foot_{side[0]}; name the feet"
        raise SceneError(said, key="character.feet")
    return min(heights, key=lambda name: heights[name])
