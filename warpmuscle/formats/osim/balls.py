"""Three hinges through bodies without mass as one ball joint: fewer bodies, no gimbal lock, the same motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warpmuscle.core.pose import multiply, rotate
from warpmuscle.formats.osim.placement import direction, vector
from warpmuscle.scene import BallCoordinates, Character, Condition, Joint, JointState, Scene
from warpmuscle.scene.topology import joints_by_parent

RIGHT_ANGLE = 1.0e-9  # what the cosine between two axes may be


def merge_balls(scene: Scene, joint_of: Mapping[str, str]) -> None:
    """Put a ball joint in the place of each three hinges that turn about axes at right angles through one point.

    Their coordinates are then angles of the ball joint, `Scene.opensim.balls`. Hinges that something else than muscles'
    conditions depends on stay.

    Args:
        joint_of: name of the joint that each coordinate belongs to, which the ball joint gets.
    """
    character = scene.character
    for names in _rows(character):
        name = joint_of.get(names[0], names[0])
        if name in character.joints and name not in names:
            continue
        if not _needed(scene, set(names)):
            _merge(scene, names, name)


def _rows(character: Character) -> list[tuple[str, str, str]]:
    """Names of three joints in a row that are a ball joint together."""
    leading = joints_by_parent(character)
    found: list[tuple[str, str, str]] = []
    taken: set[str] = set()
    for name in character.joints:
        row = [name]
        while len(row) < 3 and _empty(character, row[-1]):
            beyond = leading.get(character.joints[row[-1]].child, [])
            if len(beyond) != 1:
                break
            row += beyond
        if len(row) == 3 and not taken & set(row) and _square([character.joints[one] for one in row]):
            found.append((row[0], row[1], row[2]))
            taken |= set(row)
    return found


def _empty(character: Character, joint: str) -> bool:
    """Whether a joint leads to a body without mass."""
    return character.bodies[character.joints[joint].child].mass == 0.0


def _square(joints: list[Joint]) -> bool:
    """Whether joints are hinges about axes at right angles, through one point."""
    if any(joint.type != "hinge" for joint in joints):
        return False
    first, second, third = joints
    still = (first.position_in_child, second.position_in_parent, second.position_in_child, third.position_in_parent)
    a, b, c = (np.array(joint.axes[0], dtype=float) for joint in joints)
    return not np.any(np.array(still, dtype=float)) and max(abs(a @ b), abs(b @ c), abs(a @ c)) < RIGHT_ANGLE


def _needed(scene: Scene, names: set[str]) -> bool:
    """Whether something depends on these joints that knows nothing of a ball joint's angles."""
    character = scene.character
    followed = {joint.follows for joint in character.joints.values()}
    moved = {motion.joint for muscle in character.muscles.values() for point in muscle.path for motion in point.motion}
    fitted = [muscle.polynomial for muscle in character.muscles.values() if muscle.polynomial is not None]
    polynomial = {joint for path in fitted for joint in path.joints}
    forced = {force.joint for force in scene.forces.values()}
    drives = [scene.actuation.get(name) for name in names]
    different = any(drive != drives[0] or (drive is not None and drive.stiffness != 0.0) for drive in drives)
    return different or bool(names & (followed | moved | polynomial | forced | set(scene.motion)))


def _merge(scene: Scene, names: tuple[str, str, str], name: str) -> None:
    """One ball joint in the place of three joints."""
    character, starts = scene.character, scene.initial_state.joints
    joints = [character.joints[one] for one in names]
    first, second, third = joints
    axes = [np.array(joint.axes[0], dtype=float) for joint in joints]
    turned_round = bool(np.cross(axes[0], axes[2]) @ axes[1] < 0.0)
    ball = Joint(
        "ball", first.parent, third.child, first.position_in_parent, third.position_in_child,
        axes=[direction(axes[0]), direction(axes[2])],
        limit_stiffness=first.limit_stiffness, limit_damping=first.limit_damping,
    )  # fmt: skip
    if all(joint.limits for joint in joints):
        ball.limits = [joint.limits[0] for joint in joints]
        if turned_round:
            low, high = second.limits[0]
            ball.limits[1] = (-high, -low)  # type: ignore[operator]
    state = _start([starts.pop(one, JointState()) for one in names])
    if state != JointState():
        starts[name] = state
    character.joints = {
        (name if one == names[0] else one): (ball if one == names[0] else joint)
        for one, joint in character.joints.items()
        if one not in names[1:]
    }
    for joint in (first, second):
        del character.bodies[joint.child]
    drive = scene.actuation.pop(names[0], None)
    for one in names[1:]:
        scene.actuation.pop(one, None)
    if drive is not None:
        scene.actuation[name] = drive
    _move_conditions(character, names, name, turned_round)
    if scene.opensim is not None:
        scene.opensim.balls[name] = BallCoordinates(names, turned_round)


def _start(states: list[JointState]) -> JointState:
    """Where three hinges hold and move a body together, given one after the other."""
    turn, spin = np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3)
    for state in states:
        spin = spin + rotate(turn, np.array(state.angular_velocity, dtype=float))
        turn = multiply(turn, np.array(state.orientation, dtype=float))
    x, y, z, w = (float(value) for value in turn)
    return JointState((x, y, z, w), vector(spin))


def _move_conditions(character: Character, names: tuple[str, str, str], name: str, turned_round: bool) -> None:
    """Let conditions on three coordinates depend on the angles of one ball joint."""
    for muscle in character.muscles.values():
        if any(point.condition is not None and point.condition.joint in names for point in muscle.path):
            for point in muscle.path:
                if point.condition is not None:
                    point.condition.blend = 0.0  # as all of a path are that has one over a ball joint
        for point in muscle.path:
            condition = point.condition
            if condition is not None and condition.joint in names:
                axis = names.index(condition.joint)
                low, high = condition.low, condition.high
                if axis == 1 and turned_round:
                    low, high = -high, -low  # type: ignore[operator]
                point.condition = Condition(name, low, high, condition.blend, axis)
