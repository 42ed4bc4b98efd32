"""The accelerations that OpenSim has of bodies beyond a joint whose coordinate turns it about three axes, as a knee's.

A CustomJoint turns by t1, t2, t3 about axes w1, w2, w3, of which t1 turns the second and t1 and t2 the third. With one
coordinate the angular velocity is t1' w1 + t2' w2 + t3' w3, and w2 moves with t1' w1. Simbody lets it move with all of
the angular velocity (`MobilizedBody::FunctionBasedImpl::CacheInfo::buildHdot`), so that its angular acceleration has
t2' t3' w3 x w2 more than the derivative of its own angular velocity. Bodies beyond seem to speed up by that, and
forces that would do so are added here as loads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, rows
from warpmuscle.core.pose import about, conjugate, normalized, rotate
from warpmuscle.inverse.body_model import BodyLoads, BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.scene import Joint
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.displacement import depends, rates

AXES = 3  # turns of a joint, of which the second and the third have to depend on its coordinate


@dataclass(frozen=True)
class _Turned:
    """A joint whose coordinate turns it about three axes."""

    joint: Joint
    body: int  # its child
    coordinate: int  # that moves it, of the model's
    beyond: tuple[int, ...]  # the child, and bodies that it carries


def seeming_loads(body: BodyModel, states: States, values: Floats, speeds: Floats) -> BodyLoads | None:
    """Loads in n frames by which moments are those of OpenSim's accelerations; None where these are right.

    Args:
        values, speeds: (n, K) of the model's coordinates, rad and m, and their rates.
    """
    joints = turned_joints(body)
    if not joints or not len(values):
        return None
    nothing = BodyLoads([], *(np.zeros((len(values), 0, 3)) for _ in range(3)))
    placed = body.dynamics(states, nothing)
    numbers, forces, points, moments = [], [], [], []
    for one in joints:
        turning = _seeming_acceleration(one, placed.orientation[:, one.body], values, speeds)
        pivot = placed.position[:, one.body]
        for number in one.beyond:
            turn = placed.orientation[:, number]
            centre = placed.position[:, number] + rotate(turn, -_point_of(body, number))
            mass, moment = _inertial(body, number, turn, turning)
            numbers.append(number)
            forces.append(-mass * np.cross(turning, centre - pivot))
            points.append(centre)
            moments.append(-moment)
    return BodyLoads(numbers, *(np.stack(vectors, axis=1) for vectors in (forces, points, moments)))


def turned_joints(body: BodyModel) -> list[_Turned]:
    """The joints of a model that OpenSim turns so; those of other programs' models are none."""
    found: list[_Turned] = []
    if body.scene.opensim is None:
        return found
    names = body.topology
    for name, joint in body.scene.character.joints.items():
        driver = joint.follows or name
        if joint_type(joint).name != "coupled" or joint.beside or len(joint.rotations) != AXES:
            continue
        if driver in body.map.names and all(depends(one) for one in joint.rotations[1:]):
            number = names.body_of_joint(name)
            beyond = [number]
            for other in range(number + 1, len(names.bodies)):
                if names.parents[other] in beyond:
                    beyond.append(other)
            found.append(_Turned(joint, number, body.map.names.index(driver), tuple(beyond)))
    return found


def _seeming_acceleration(one: _Turned, orientation: Floats, values: Floats, speeds: Floats) -> Floats:
    """By how much bodies beyond a joint seem to turn faster (n, 3), rad/s^2, world axes.

    Args:
        orientation: (n, 4) of the joint's child.
    """
    second, third = one.joint.rotations[1:]
    q, rate = values[:, one.coordinate], speeds[:, one.coordinate]
    _, slope, _ = rates(second, q)
    angle, other, _ = rates(third, q)
    axes = [np.asarray(normalized(rows(each.axis))[0]) for each in (second, third)]
    before = rotate(conjugate(about(axes[1], angle)), np.broadcast_to(axes[0], (len(q), 3)))  # in the child's axes
    along = rotate(orientation, np.cross(np.broadcast_to(axes[1], before.shape), before))
    return np.asarray(along * (slope * other * rate**2)[:, None])


def _point_of(body: BodyModel, number: int) -> Floats:
    """Where the joint of a body is on it (3,), m, from its centre of mass."""
    joint = body.scene.character.joints[body.topology.joints[number - 1]]
    return np.array([first_number(x) for x in joint.position_in_child])


def _inertial(body: BodyModel, number: int, turn: Floats, turning: Floats) -> tuple[float, Floats]:
    """A body's mass, kg, and the moment (n, 3), N m, about its centre that turns it faster by so much."""
    own = body.scene.character.bodies[body.topology.bodies[number]]
    axes = normalized(np.array([first_number(x) for x in own.inertia_axes]))
    inertia = np.array([first_number(x) for x in own.inertia])
    back = rotate(conjugate(axes), rotate(conjugate(turn), turning))
    return float(first_number(own.mass)), np.asarray(rotate(turn, rotate(axes, inertia * back)))
