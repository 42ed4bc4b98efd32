"""Forces that a motion needs: inverse dynamics of a character's tree by recursive Newton-Euler, in float64.

World axes about each body's joint, as in `kernels.body.dynamics` (Featherstone 2008, ch. 5). All states of a motion are
handled at once. Muscles, springs, dampers, limits and contacts play no part: the result is what they must sum up to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import conjugate, multiply, normalized, rotate
from warpmuscle.scene import Body, Character, Joint, Scene
from warpmuscle.scene.joints import JointKinematics, RootType, joint_type, root_type
from warpmuscle.scene.joints.displacement import rates
from warpmuscle.scene.parameters import at_start, start_values, substitute
from warpmuscle.scene.topology import Topology, topology

Moving = tuple[Floats, Floats, Floats]  # coordinates (n, C), speeds (n, S), accelerations (n, S)


@dataclass
class _Body:
    """Motion of a body's joint, and of the body about it, in n states; world axes."""

    orientation: Floats  # (n, 4)
    angular_velocity: Floats  # (n, 3) rad/s
    angular_acceleration: Floats  # (n, 3) rad/s^2
    position: Floats  # (n, 3) m, of the joint
    acceleration: Floats  # (n, 3) m/s^2, of the joint
    turning: list[Floats]  # (n, 3) each, angular velocity by a unit of each of the joint's speeds
    moving: list[Floats]  # (n, 3) each, velocity of the joint


def inverse_dynamics(
    scene: Scene, coordinates: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike, values: ArrayLike | None = None
) -> Floats:
    """Generalised forces (n, S), N and N m, that make a character move so.

    Args:
        scene: its character and gravity count.
        coordinates: (n, C) as in `rollout.state`: of the root first (position, m, and quaternion, or y, z and turn of a
            planar one), then of the joints in the order of `topology`. speeds: (n, S). accelerations: (n, S), their
            rates.
        values: of the scene's free parameters, (P,); by default their start values.

    Raises:
        Error: arrays of other shapes, or numbers that are not finite.
    """
    plain = substitute(scene, start_values(scene) if values is None else np.asarray(values, dtype=np.float64))
    character = plain.character
    names = topology(character)
    motion = _checked(names, coordinates, speeds, accelerations)
    bodies = _outward(character, names, motion)
    needed = _inward(character, names, bodies, float(plain.gravity))  # type: ignore[arg-type]
    return needed + _armatures(character, names, motion)


@dataclass(frozen=True)
class JointSpace:
    """The equations of motion M q'' + c = g + forces of a character in n poses, in float64."""

    mass_matrix: Floats  # (n, S, S) of the speeds
    gravity: Floats  # (n, S) g, generalised forces of gravity, N and N m


def joint_space(scene: Scene, coordinates: ArrayLike, values: ArrayLike | None = None) -> JointSpace:
    """Mass matrix and forces of gravity of a character in poses (n, C), see `inverse_dynamics`.

    What the forces c of the velocities are is `inverse_dynamics` at no accelerations, and g added.

    Raises:
        Error: see there.
    """
    q = np.asarray(coordinates, dtype=np.float64)
    names = topology(scene.character)
    still = np.zeros((len(np.atleast_2d(q)), names.speeds))
    held = inverse_dynamics(scene, q, still, still, values)
    columns = [inverse_dynamics(scene, q, still, still + unit, values) - held for unit in np.eye(names.speeds)]
    matrix = np.stack(columns, axis=-1) if columns else np.zeros((len(still), 0, 0))
    return JointSpace(0.5 * (matrix + np.swapaxes(matrix, 1, 2)), -held)


def body_points(scene: Scene, coordinates: ArrayLike) -> dict[str, tuple[Floats, Floats]]:
    """Position (n, 3), m, of every body's joint and the body's orientation (n, 4), by name of the body."""
    return points_of(at_start(scene).character, coordinates)


def points_of(character: Character, coordinates: ArrayLike) -> dict[str, tuple[Floats, Floats]]:
    """As `body_points`, of a character without free parameters."""
    names = topology(character)
    still = np.zeros((len(np.atleast_2d(np.asarray(coordinates))), names.speeds))
    q, v, _ = _checked(names, coordinates, still, still)
    root = root_type(character).motion(q)
    found = [(np.asarray(root.place), np.asarray(root.orientation))]
    for number, name in enumerate(names.joints, start=1):
        joint, (place, orientation) = character.joints[name], found[names.parents[number]]
        moving, rates = names.arguments_of(number)
        own = joint_type(joint).motion(joint, q[:, moving], v[:, rates])
        place = place + rotate(orientation, _anchor(character, names, number) + own.place)
        found.append((place, multiply(orientation, own.orientation)))
    return dict(zip(names.bodies, found, strict=True))


class BodyMotion(NamedTuple):
    """Motion of a body in n states, world axes."""

    position: Floats  # (n, 3) m, of its joint
    orientation: Floats  # (n, 4)
    angular_velocity: Floats  # (n, 3) rad/s
    turning: list[Floats]  # (n, 3) each, angular velocity by a unit of each of its joint's speeds


def body_motions(scene: Scene, coordinates: ArrayLike, speeds: ArrayLike) -> dict[str, BodyMotion]:
    """Motion of every body, by name, root first.

    Args:
        scene: without free parameters. coordinates, speeds: see `inverse_dynamics`.

    Raises:
        Error: see there.
    """
    names = topology(scene.character)
    bodies = _outward(scene.character, names, _checked(names, coordinates, speeds, np.zeros(np.shape(speeds))))
    return {
        name: BodyMotion(one.position, one.orientation, one.angular_velocity, one.turning)
        for name, one in zip(names.bodies, bodies, strict=True)
    }


def body_accelerations(
    scene: Scene, coordinates: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike
) -> dict[str, tuple[Floats, Floats]]:
    """Acceleration (n, 3), m/s^2, of every body's joint and angular acceleration (n, 3), rad/s^2, by name of the body.

    Args:
        scene: without free parameters. coordinates, speeds, accelerations: see `inverse_dynamics`.

    Raises:
        Error: see there.
    """
    names = topology(scene.character)
    bodies = _outward(scene.character, names, _checked(names, coordinates, speeds, accelerations))
    return {
        name: (body.acceleration, body.angular_acceleration) for name, body in zip(names.bodies, bodies, strict=True)
    }


def _checked(names: Topology, coordinates: ArrayLike, speeds: ArrayLike, accelerations: ArrayLike) -> Moving:
    q, v, a = (np.asarray(x, dtype=np.float64) for x in (coordinates, speeds, accelerations))
    if q.ndim != 2 or q.shape[1] != names.coordinates or v.shape != (len(q), names.speeds) or a.shape != v.shape:
        raise Error(
            f"inverse dynamics takes (n, {names.coordinates}) coordinates and (n, {names.speeds}) speeds and "
            f"accelerations, not {q.shape}, {v.shape} and {a.shape}"
        )
    if not all(np.isfinite(x).all() for x in (q, v, a)):
        raise Error("inverse dynamics: a coordinate, speed or acceleration is not a finite number")
    return q, v, a


def _outward(character: Character, names: Topology, motion: Moving) -> list[_Body]:
    """Motion of all bodies, from the root on."""
    bodies = [_root(root_type(character), motion)]
    for number, name in enumerate(names.joints, start=1):
        joint, parent, anchor = character.joints[name], bodies[names.parents[number]], _anchor(character, names, number)
        coordinates, speeds = names.arguments_of(number)
        q, v, a = motion[0][:, coordinates], motion[1][:, speeds], motion[2][:, speeds]
        bodies.append(_child(joint_type(joint).motion(joint, q, v), parent, anchor, v, a))
    return bodies


def _anchor(character: Character, names: Topology, number: int) -> Floats:
    """Where the motion of a body's joint starts from, from its parent's joint, (1, 3) m, axes of the parent."""
    anchor = rows(character.joints[names.joints[number - 1]].position_in_parent)
    if names.parents[number] > 0:
        anchor = anchor - rows(character.joints[names.joints[names.parents[number] - 1]].position_in_child)
    return anchor


def _root(kind: RootType, motion: Moving) -> _Body:
    q, v, a = motion
    world = kind.motion(q)
    angular, alpha = _sum(world.turning, v), _sum(world.turning, a)
    turning, moving = world.turning, world.moving
    return _Body(world.orientation, angular, alpha, world.place, _sum(moving, a), turning, moving)


def _child(own: JointKinematics, parent: _Body, anchor: Floats, v: Floats, a: Floats) -> _Body:
    """Motion of a joint's child; anchor (1, 3) from the parent's joint to where the joint's motion starts from."""

    def world(vector: Floats) -> Floats:
        return rotate(parent.orientation, vector)

    r, w = world(anchor + own.place), parent.angular_velocity
    turning, moving = [world(axis) for axis in own.turning], [world(axis) for axis in own.moving]
    relative, velocity = _sum(turning, v), _sum(moving, v)
    alpha = parent.angular_acceleration + _sum(turning, a) + world(own.turning_drift) + np.cross(w, relative)
    acceleration = parent.acceleration + np.cross(parent.angular_acceleration, r) + np.cross(w, np.cross(w, r))
    acceleration = acceleration + _sum(moving, a) + world(own.moving_drift) + 2.0 * np.cross(w, velocity)
    orientation = multiply(parent.orientation, own.orientation)
    return _Body(orientation, w + relative, alpha, parent.position + r, acceleration, turning, moving)


def _sum(axes: list[Floats], rates: Floats) -> Floats:
    """The sum of axes (n, 3) times their rates, columns of (n, S) or its first ones."""
    return sum((axis * rates[:, i : i + 1] for i, axis in enumerate(axes)), start=np.zeros((len(rates), 3)))


def _inward(character: Character, names: Topology, bodies: list[_Body], gravity: float) -> Floats:
    """Generalised forces, from the last bodies back to the root."""
    count = len(bodies[0].position)
    force = [np.zeros((count, 3)) for _ in bodies]
    moment = [np.zeros((count, 3)) for _ in bodies]
    result = np.zeros((count, names.speeds))
    for number in range(len(bodies) - 1, -1, -1):
        body, part = bodies[number], character.bodies[names.bodies[number]]
        offset = rows((0.0, 0.0, 0.0)) if number == 0 else -rows(_joint(character, names, number).position_in_child)
        own_force, own_moment = _newton_euler(body, part, offset, gravity)
        force[number] += own_force
        moment[number] += own_moment
        if number > 0:
            parent = names.parents[number]
            r = body.position - bodies[parent].position
            force[parent] += force[number]
            moment[parent] += moment[number] + np.cross(r, force[number])
        start = names.speeds_of(number).start
        for i, (turning, moving) in enumerate(zip(body.turning, body.moving, strict=True)):
            result[:, start + i] += np.sum(turning * moment[number] + moving * force[number], axis=-1)
    return result


def _armatures(character: Character, names: Topology, motion: Moving) -> Floats:
    """Generalised forces (n, S) that the armatures of joints need, also of those that follow others."""
    q, v, a = motion
    result = np.zeros_like(v)
    for number, name in enumerate(names.joints, start=1):
        joint = character.joints[name]
        own, driver = rows(joint.armature), names.driver[number]
        speeds = names.speeds_of(driver)
        if not joint.follows:
            result[:, speeds] += own * a[:, speeds]
            continue
        of_driver = q[:, names.coordinates_of(driver).start]
        for displacement in (*joint.rotations, *joint.translations):
            _, first, second = rates(displacement, of_driver)
            inertia = first * a[:, speeds.start] + second * v[:, speeds.start] ** 2
            result[:, speeds.start] += own * first * inertia
    return result


def _joint(character: Character, names: Topology, body: int) -> Joint:
    return character.joints[names.joints[body - 1]]


def _newton_euler(body: _Body, part: Body, com: Floats, gravity: float) -> tuple[Floats, Floats]:
    """Force and moment about its joint that a body alone needs; com from the joint in the body's axes."""
    inertia, axes = rows(list(part.inertia)), multiply(body.orientation, normalized(rows(part.inertia_axes)))
    c, w, alpha = rotate(body.orientation, com), body.angular_velocity, body.angular_acceleration
    acceleration = body.acceleration + np.cross(alpha, c) + np.cross(w, np.cross(w, c)) + [0.0, gravity, 0.0]
    force = rows(part.mass) * acceleration
    inverse = conjugate(axes)
    local_w, local_alpha = rotate(inverse, w), rotate(inverse, alpha)
    spin = rotate(axes, inertia * local_alpha + np.cross(local_w, inertia * local_w))
    return force, spin + np.cross(c, force)
