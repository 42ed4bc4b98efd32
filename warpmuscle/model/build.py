"""A scene as the device structures of a batch: the model, and the states that instances start from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows, to_device
from warpmuscle.core.pose import (
    conjugate,
    hinge_coordinates,
    multiply,
    normalized,
    rotate,
    turned_to_heading,
    twist_angle,
    universal_coordinates,
)
from warpmuscle.kernels import structs
from warpmuscle.model.bodies import contacts_struct, joint_axes, skeleton_struct
from warpmuscle.model.controller import controller_struct
from warpmuscle.model.muscles import ActuationMap, model_parts
from warpmuscle.model.objective import objective_fields
from warpmuscle.scene import InitialState, Joint, JointState, Scene
from warpmuscle.scene.topology import Topology

X_AXIS = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class Start:
    """What instances start from: coordinates (rows, C) and speeds (rows, S), rows 1 or the number of instances."""

    coordinates: Floats
    speeds: Floats
    stance: int
    machine_state: int
    activation: Floats  # (rows, 1) of the muscles


def model_struct(scene: Scene, names: Topology, found: ActuationMap, device: Any) -> structs.Model:
    """The device structure of a scene.

    Args:
        scene: checked scene whose numbers are floats, or (n,) arrays with one value an instance (see
            `parameters.substitute`).
        found: what drives the joints, see `muscles.driven`.
    """
    failure = [scene.failure.com_height, scene.failure.heading, scene.failure.max_speed, scene.failure.leg_crossing]
    m = structs.Model()
    m.body_count = len(names.bodies)
    m.level_count = len(names.level_start) - 1
    m.implicit_pd = int(scene.implicit_pd)
    m.time_step = scene.time_step
    m.fail_on_body_contact = int(scene.failure.body_contact)
    m.gravity = to_device(rows([scene.gravity]), float, device)
    m.failure = to_device(rows([failure]), wp.vec4, device)
    m.fastest = scene.failure.max_com_speed
    m.level_start = to_device(names.level_start, int, device)
    m.contacts, points = contacts_struct(scene, names, device)
    m.skeleton = skeleton_struct(scene, names, points, device)
    m.foot_slots = m.skeleton.foot_side.shape[0] if scene.controller is not None else 0
    m.simbicon = controller_struct(scene, names, device)
    for field, part in objective_fields(scene, names, device).items():
        setattr(m, field, part)
    for field, part in model_parts(scene, names, found, device).items():
        setattr(m, field, part)
    return m


def start_of(scene: Scene, names: Topology) -> Start:
    """Coordinates and speeds of a scene's initial state; quaternions are normalised here."""
    state = scene.initial_state
    coordinates, speeds = _root_start(state, scene.character.root_joint)
    parts_q, parts_v = [coordinates], [speeds]
    for name in names.joints:
        q, v = _joint_start(scene.character.joints[name], state.joints.get(name, JointState()))
        parts_q.append(q)
        parts_v.append(v)
    controller = scene.controller
    return Start(
        coordinates=_beside(parts_q),
        speeds=_beside(parts_v),
        stance=int(controller is not None and controller.start_stance == "right"),
        machine_state=0 if controller is None else controller.start_state,
        activation=rows([scene.muscle_model.initial_activation]),
    )


def _root_start(state: InitialState, kind: str) -> tuple[Floats, Floats]:
    q = normalized(rows(state.root_orientation))
    position, velocity, angular = (
        rows(v) for v in (state.root_position, state.root_velocity, state.root_angular_velocity)
    )
    if state.heading is not None:
        turn = turned_to_heading(q, rows(state.heading))
        q, velocity, angular = multiply(turn, q), rotate(turn, velocity), rotate(turn, angular)
    return root_coordinates(kind, position, q, velocity, angular)


def root_coordinates(
    kind: str, position: Floats, orientation: Floats, velocity: Floats, angular_velocity: Floats
) -> tuple[Floats, Floats]:
    """Coordinates and speeds of a free, planar or fixed root from its motion in the world, (n, 3) and (n, 4) each."""
    if kind == "free":
        return _beside([position, orientation]), _beside([velocity, angular_velocity])
    if kind == "planar":
        turn = twist_angle(orientation, X_AXIS)[:, None]
        return _beside([position[:, 1:], turn]), _beside([velocity[:, 1:], angular_velocity[:, :1]])
    return _beside([position, orientation]), np.zeros((len(position), 0))


def _joint_start(joint: Joint, state: JointState) -> tuple[Floats, Floats]:
    return joint_coordinates(joint, normalized(rows(state.orientation)), rows(state.angular_velocity))


def joint_coordinates(joint: Joint, orientation: Floats, angular_velocity: Floats) -> tuple[Floats, Floats]:
    """Coordinates and speeds of a joint from the child's motion relative to the parent.

    Args:
        orientation: child in parent, (n, 4) unit quaternions.
        angular_velocity: of the child relative to the parent, parent axes, (n, 3), rad/s.
    """
    a, b = joint_axes(joint)
    if joint.type == "ball":
        return orientation, rotate(conjugate(orientation), angular_velocity)
    if joint.type == "hinge":
        return hinge_coordinates(orientation, angular_velocity, a)
    if joint.type == "universal":
        return universal_coordinates(orientation, angular_velocity, a, b)
    return np.zeros((len(orientation), 0)), np.zeros((len(orientation), 0))


def _beside(parts: list[Floats]) -> Floats:
    """(rows, k) arrays side by side, single rows repeated as often as needed."""
    count = max(len(part) for part in parts)
    return np.concatenate([np.broadcast_to(part, (count, part.shape[1])) for part in parts], axis=1)
