"""Forces that a motion needs: inverse dynamics of a character's tree by recursive Newton-Euler, in float64.

World axes about each body's joint, as in `kernels/dynamics.py` (Featherstone 2008, ch. 5). All states of a motion are
handled at once. Muscles, springs, joint limits and contacts play no part: the result is what they must sum up to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import about, multiply, normalized, rotate
from warpmuscle.model.bodies import joint_axes
from warpmuscle.scene import Character, Joint, Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.topology import Topology, topology

X_AXIS = np.array([1.0, 0.0, 0.0])
Moving = tuple[Floats, Floats, Floats]  # coordinates (n, C), speeds (n, S), accelerations (n, S)


@dataclass
class _Body:
    """Motion of a body's joint, and of the body about it, in n states; world axes."""

    orientation: Floats  # (n, 4)
    angular_velocity: Floats  # (n, 3) rad/s
    angular_acceleration: Floats  # (n, 3) rad/s^2
    position: Floats  # (n, 3) m, of the joint
    acceleration: Floats  # (n, 3) m/s^2, of the joint
    axes: list[Floats]  # (n, 3) each, of the speeds that turn it


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
    return _inward(character, names, bodies, float(plain.gravity))  # type: ignore[arg-type]


def body_points(scene: Scene, coordinates: ArrayLike) -> dict[str, tuple[Floats, Floats]]:
    """Position (n, 3), m, of every body's joint and the body's orientation (n, 4), by name of the body."""
    plain = substitute(scene, start_values(scene))
    names = topology(plain.character)
    still = np.zeros((len(np.atleast_2d(np.asarray(coordinates))), names.speeds))
    bodies = _outward(plain.character, names, _checked(names, coordinates, still, still))
    return {name: (body.position, body.orientation) for name, body in zip(names.bodies, bodies, strict=True)}


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
    bodies = [_root(character.root_joint, motion)]
    for number, name in enumerate(names.joints, start=1):
        joint, parent = character.joints[name], bodies[names.parents[number]]
        anchor = rows(joint.position_in_parent)
        if names.parents[number] > 0:
            anchor = anchor - rows(character.joints[names.joints[names.parents[number] - 1]].position_in_child)
        r = rotate(parent.orientation, anchor)
        q, v, a = (
            part[:, start[number] : start[number + 1]]
            for part, start in zip(motion, (names.coordinate_start, names.speed_start, names.speed_start), strict=True)
        )
        bodies.append(_child(joint, parent, r, q, v, a))
    return bodies


def _root(kind: str, motion: Moving) -> _Body:
    q, v, a = motion
    zero = np.zeros((len(q), 3))
    if kind == "free":
        return _Body(normalized(q[:, 3:7]), v[:, 3:6], a[:, 3:6], q[:, :3], a[:, :3], [])
    if kind == "fixed":
        return _Body(normalized(q[:, 3:7]), zero, zero, q[:, :3], zero, [])
    position, angular, alpha, acceleration = (np.zeros((len(q), 3)) for _ in range(4))
    position[:, 1:], acceleration[:, 1:] = q[:, :2], a[:, :2]
    angular[:, 0], alpha[:, 0] = v[:, 2], a[:, 2]
    return _Body(about(X_AXIS, q[:, 2]), angular, alpha, position, acceleration, [])


def _child(joint: Joint, parent: _Body, r: Floats, q: Floats, v: Floats, a: Floats) -> _Body:
    """Motion of a joint's child; r (n, 3) from the parent's joint to this one."""
    axis_a, axis_b = joint_axes(joint)
    w = parent.angular_velocity
    axes: list[Floats] = []
    rates: list[Floats] = []
    turned: list[Floats] = []  # angular velocity of what each axis is fixed to
    if joint.type == "ball":
        orientation = multiply(parent.orientation, normalized(q))
        axes = [rotate(orientation, np.broadcast_to(unit, (len(q), 3))) for unit in np.eye(3)]
        relative = sum(axis * v[:, i : i + 1] for i, axis in enumerate(axes))
        turned = [w + relative] * 3
    elif joint.type == "hinge":
        orientation = multiply(parent.orientation, about(axis_a, q[:, 0]))
        axes, turned = [rotate(orientation, axis_a)], [w]
    elif joint.type == "universal":
        orientation = multiply(parent.orientation, multiply(about(axis_b, q[:, 1]), about(axis_a, q[:, 0])))
        axes = [rotate(orientation, axis_a), rotate(parent.orientation, axis_b)]
        turned = [w + axes[0] * v[:, :1] + axes[1] * v[:, 1:], w]
    else:
        orientation = parent.orientation
    rates = [axis * v[:, i : i + 1] for i, axis in enumerate(axes)]
    alpha = parent.angular_acceleration.copy()
    for i, axis in enumerate(axes):
        alpha += axis * a[:, i : i + 1] + np.cross(turned[i], rates[i])
    acceleration = parent.acceleration + np.cross(parent.angular_acceleration, r) + np.cross(w, np.cross(w, r))
    angular = w + sum(rates, start=np.zeros_like(w))
    return _Body(orientation, angular, alpha, parent.position + r, acceleration, axes)


def _inward(character: Character, names: Topology, bodies: list[_Body], gravity: float) -> Floats:
    """Generalised forces, from the last bodies back to the root."""
    count = len(bodies[0].position)
    force = [np.zeros((count, 3)) for _ in bodies]
    moment = [np.zeros((count, 3)) for _ in bodies]
    result = np.zeros((count, names.speeds))
    for number in range(len(bodies) - 1, -1, -1):
        body, part = bodies[number], character.bodies[names.bodies[number]]
        offset = rows((0.0, 0.0, 0.0)) if number == 0 else -rows(_joint(character, names, number).position_in_child)
        own_force, own_moment = _newton_euler(body, rows(part.mass)[0], rows(list(part.inertia)), offset, gravity)
        force[number] += own_force
        moment[number] += own_moment
        if number > 0:
            parent = names.parents[number]
            r = body.position - bodies[parent].position
            force[parent] += force[number]
            moment[parent] += moment[number] + np.cross(r, force[number])
        start = names.speed_start[number]
        for i, axis in enumerate(body.axes):
            result[:, start + i] = np.sum(axis * moment[number], axis=-1)
    if character.root_joint == "free":
        result[:, :3], result[:, 3:6] = force[0], moment[0]
    elif character.root_joint == "planar":
        result[:, :2], result[:, 2] = force[0][:, 1:], moment[0][:, 0]
    return result


def _joint(character: Character, names: Topology, body: int) -> Joint:
    return character.joints[names.joints[body - 1]]


def _newton_euler(body: _Body, mass: float, inertia: Floats, com: Floats, gravity: float) -> tuple[Floats, Floats]:
    """Force and moment about its joint that a body alone needs; com from the joint in the body's axes."""
    c, w, alpha = rotate(body.orientation, com), body.angular_velocity, body.angular_acceleration
    acceleration = body.acceleration + np.cross(alpha, c) + np.cross(w, np.cross(w, c)) + [0.0, gravity, 0.0]
    force = mass * acceleration
    inverse = body.orientation * [-1.0, -1.0, -1.0, 1.0]
    local_w, local_alpha = rotate(inverse, w), rotate(inverse, alpha)
    spin = rotate(body.orientation, inertia * local_alpha + np.cross(local_w, inertia * local_w))
    return force, spin + np.cross(c, force)
