"""Where the bodies of a character are in the initial pose, as far as the host has to know."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import multiply, normalized, rotate, turned_to_heading
from warpmuscle.scene import Joint, JointState, Scene
from warpmuscle.scene.joints import joint_type, root_type
from warpmuscle.scene.number import Number
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.topology import topology

Poses = dict[str, tuple[Floats, Floats]]  # position, m, and orientation by body


def initial_pose(scene: Scene) -> tuple[Poses, dict[str, Floats]]:
    """Position, m, and orientation of every body in the root's frame, and the angles, rad, of every joint.

    Args:
        scene: checked scene without free parameters.
    """
    character = scene.character
    poses: Poses = {character.root: (np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))}
    angles, moved = {}, {}
    for name, joint in character.joints.items():
        q, v = joint_type(joint).start(joint, scene.initial_state.joints.get(name, JointState()))
        moved[name], angles[name] = (q, v), joint_type(joint).angles_of(joint, q)[0]
    for name in topology(character).joints:
        joint = character.joints[name]
        kind = joint_type(joint)
        motion = kind.motion(joint, *arguments(joint, name, moved))
        position, orientation = poses[joint.parent]
        anchor = position + rotate(orientation, plain_vector(joint.position_in_parent) + motion.place[0])
        turned = multiply(orientation, motion.orientation[0])
        poses[joint.child] = np.asarray(anchor - rotate(turned, plain_vector(joint.position_in_child))), turned
    return poses, angles


def arguments(joint: Joint, name: str, moved: dict[str, tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """Coordinates (n, C) and speeds (n, S) that the motion of a joint depends on, from those of all joints."""
    q, v = moved[joint.follows or name]
    if not joint.beside:
        return q, v
    other_q, other_v = moved[joint.beside]
    return np.concatenate([q, other_q], axis=1), np.concatenate([v, other_v], axis=1)


def world_poses(scene: Scene) -> Poses:
    """Position, m, and orientation of every body at the start, world.

    Args:
        scene: checked scene without free parameters.
    """
    place, turn = _root(scene)
    poses, _ = initial_pose(scene)
    return {
        name: (place + rotate(turn, position), multiply(turn, orientation))
        for name, (position, orientation) in poses.items()
    }


def _root(scene: Scene) -> tuple[Floats, Floats]:
    """Position, m, and orientation of the root at the start, world."""
    state = scene.initial_state
    position, turn = plain_vector(state.root_position), normalized(plain_vector(state.root_orientation))
    if state.heading is not None:
        turn = multiply(turned_to_heading(turn, plain_number(state.heading)), turn)
    root, still = root_type(scene.character), np.zeros((1, 3))
    motion = root.motion(root.coordinates_of(position[None], turn[None], still, still)[0])
    place = motion.place[0]
    if scene.ground.terrain is not None and root.moving:
        rise = surface(scene.ground).highest_rise(place[0], place[2], scene.ground.terrain.clearing)
        place = place + np.array([0.0, rise, 0.0])
    return place, motion.orientation[0]


def plain_vector(numbers: Sequence[Number]) -> Floats:
    """Numbers (n,) of a scene that has no free parameters as an array (n,)."""
    return np.array([plain_number(number) for number in numbers])


def plain_number(number: Number) -> float:
    """A number of a scene that has no free parameters."""
    assert isinstance(number, int | float)
    return float(number)
