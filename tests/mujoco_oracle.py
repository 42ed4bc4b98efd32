"""MuJoCo in double precision as an oracle of forward dynamics, through the package's own MJCF export.

Joints and bodies are in the order of `random_states`; quaternions xyzw.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from biped import breadth_first, rotate
from random_states import States, body_order, turn, unit
from warpmuscle.formats import mjcf
from warpmuscle.scene import Character, Joint, Scene


@dataclass(frozen=True)
class Accelerations:
    """Accelerations of B bodies in N states, in world coordinates."""

    angular: np.ndarray  # (N, B, 3) rad/s^2
    linear: np.ndarray  # (N, B, 3) m/s^2, of the centres of mass
    generalized: np.ndarray  # (N, nv) MuJoCo's qacc


def compile_model(scene: Scene) -> mujoco.MjModel:
    """The exported character, without contacts."""
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    return model


def accelerations(scene: Scene, states: States, joint_torque: np.ndarray) -> Accelerations:
    """Accelerations under gravity and joint torques (N, J, 3), N m, world, + on the parent and - on the child."""
    model, character = compile_model(scene), scene.character
    bodies = [model.body(name).id for name in body_order(character)]
    angular, linear = np.empty((2, len(states), len(bodies), 3))
    generalized = np.empty((len(states), model.nv))
    for index in range(len(states)):
        data = _prepare(model, character, states, index)
        for name, torque in zip(breadth_first(character), joint_torque[index], strict=True):
            joint = character.joints[name]
            data.xfrc_applied[model.body(joint.parent).id, 3:] += torque
            data.xfrc_applied[model.body(joint.child).id, 3:] -= torque
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        generalized[index] = data.qacc
        for place, body in enumerate(bodies):
            both = np.empty(6)
            mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_BODY, body, both, 0)
            angular[index, place] = both[:3]
            linear[index, place] = both[3:] + model.opt.gravity  # MuJoCo's world accelerates upwards instead
    return Accelerations(angular, linear, generalized)


def body_states(scene: Scene, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Position (N, B, 3), orientation (N, B, 4), velocity and angular velocity (N, B, 3) of all bodies, world."""
    model, character = compile_model(scene), scene.character
    bodies = [model.body(name).id for name in body_order(character)]
    position, velocity, angular_velocity = np.empty((3, len(states), len(bodies), 3))
    orientation = np.empty((len(states), len(bodies), 4))
    for index in range(len(states)):
        data = _prepare(model, character, states, index)
        mujoco.mj_forward(model, data)
        position[index], orientation[index] = data.xpos[bodies], np.roll(data.xquat[bodies], -1, axis=-1)
        for place, body in enumerate(bodies):
            both = np.empty(6)
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, both, 0)
            angular_velocity[index, place], velocity[index, place] = both[:3], both[3:]
    return position, orientation, velocity, angular_velocity


def mass_matrix(scene: Scene, states: States) -> np.ndarray:
    """Joint-space mass matrices (N, nv, nv) in MuJoCo's order and choice of velocities (see `state_to_qpos`)."""
    model = compile_model(scene)
    matrices = np.empty((len(states), model.nv, model.nv))
    for index in range(len(states)):
        data = _prepare(model, scene.character, states, index)
        mujoco.mj_forward(model, data)
        for column, along in enumerate(np.eye(model.nv)):
            mujoco.mj_mulM(model, data, matrices[index, column], along)
    return matrices


def state_to_qpos(
    model: mujoco.MjModel, character: Character, states: States, index: int
) -> tuple[np.ndarray, np.ndarray]:
    """MuJoCo's qpos (nq,) and qvel (nv,) of one state.

    A free root moves by its world velocity and its angular velocity in its own frame, a ball joint by its relative
    angular velocity in the child's frame. Components that a joint does not allow are dropped.
    """
    qpos, qvel = model.qpos0.copy(), np.zeros(model.nv)
    _set_root(model, character, states, index, qpos, qvel)
    for place, name in enumerate(breadth_first(character)):
        joint = character.joints[name]
        orientation = states.joint_orientation[index, place]
        angular_velocity = states.joint_angular_velocity[index, place]
        if joint.type == "ball":
            at, moves = model.joint(name).qposadr[0], model.joint(name).dofadr[0]
            qpos[at : at + 4] = np.roll(orientation, 1)
            qvel[moves : moves + 3] = rotate(_inverse(orientation), angular_velocity)
        elif joint.type != "fixed":
            labels = [name] if joint.type == "hinge" else [f"{name}_a", f"{name}_b"]
            for label, angle, rate in zip(labels, *_coordinates(joint, orientation, angular_velocity), strict=True):
                qpos[model.joint(label).qposadr[0]], qvel[model.joint(label).dofadr[0]] = angle, rate
    return qpos, qvel


def _prepare(model: mujoco.MjModel, character: Character, states: States, index: int) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos, data.qvel = state_to_qpos(model, character, states, index)
    return data


def _set_root(
    model: mujoco.MjModel, character: Character, states: States, index: int, qpos: np.ndarray, qvel: np.ndarray
) -> None:
    """Fill in the root's part; a free root is the first joint, a planar one the first three."""
    position, orientation = states.root_position[index], states.root_orientation[index]
    velocity, angular_velocity = states.root_velocity[index], states.root_angular_velocity[index]
    if character.root_joint == "free":
        qpos[:3], qpos[3:7] = position, np.roll(orientation, 1)
        qvel[:3], qvel[3:6] = velocity, rotate(_inverse(orientation), angular_velocity)
    elif character.root_joint == "planar":
        qpos[:3] = position[1], position[2], 2.0 * np.arctan2(orientation[0], orientation[3])
        qvel[:3] = velocity[1], velocity[2], angular_velocity[0]


def _coordinates(joint: Joint, orientation: np.ndarray, angular_velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles and rates about the axes of a hinge, or of a universal joint with axes at right angles."""
    axes = unit(np.array(joint.axes, dtype=float))
    angles = 2.0 * np.arctan2(axes @ orientation[:3], orientation[3])
    if len(axes) == 1:
        return angles, axes @ angular_velocity
    turned = np.stack([rotate(turn(axes[1], angles[1:])[0], axes[0]), axes[1]])  # as they are in the parent
    return angles, turned @ angular_velocity


def _inverse(quaternion: np.ndarray) -> np.ndarray:
    return quaternion * [-1.0, -1.0, -1.0, 1.0]
