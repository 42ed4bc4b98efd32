"""MuJoCo in double precision as an oracle of forward dynamics, through the package's own MJCF export.

Joints are in breadth-first order from the root, bodies are the root followed by the joints' children; quaternions xyzw.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import mujoco
import numpy as np

from biped import breadth_first, multiply, rotate
from warpmuscle.formats import mjcf
from warpmuscle.scene import Character, Joint, Scene


@dataclass(frozen=True)
class States:
    """N states of a character with J joints."""

    root_position: np.ndarray  # (N, 3) m, world
    root_orientation: np.ndarray  # (N, 4)
    root_velocity: np.ndarray  # (N, 3) m/s, world
    root_angular_velocity: np.ndarray  # (N, 3) rad/s, world
    joint_orientation: np.ndarray  # (N, J, 4) child to parent
    joint_angular_velocity: np.ndarray  # (N, J, 3) rad/s, child relative to parent, in the parent's frame

    def __getitem__(self, index: slice | np.ndarray) -> States:
        return States(*(getattr(self, field.name)[index] for field in fields(self)))

    def __len__(self) -> int:
        return len(self.root_position)


@dataclass(frozen=True)
class Accelerations:
    """Accelerations of B bodies in N states, in world coordinates."""

    angular: np.ndarray  # (N, B, 3) rad/s^2
    linear: np.ndarray  # (N, B, 3) m/s^2, of the centres of mass
    generalized: np.ndarray  # (N, nv) MuJoCo's qacc


def body_order(character: Character) -> list[str]:
    """Names of the bodies: the root, then the children of the joints."""
    return [character.root, *(character.joints[name].child for name in breadth_first(character))]


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
        for column, unit in enumerate(np.eye(model.nv)):
            mujoco.mj_mulM(model, data, matrices[index, column], unit)
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


def random_states(character: Character, count: int, seed: int = 0, speed: float = 3.0) -> States:
    """States all over the place but with joints moving as they can: speeds are normal with this deviation."""
    rng = np.random.default_rng(seed)
    names = breadth_first(character)
    orientation, velocity = np.empty((count, len(names), 4)), np.empty((count, len(names), 3))
    for place, name in enumerate(names):
        joint = character.joints[name]
        if joint.type == "ball":
            orientation[:, place] = _unit(rng.normal([0.0, 0.0, 0.0, 3.0], size=(count, 4)))
            velocity[:, place] = rng.normal(size=(count, 3)) * speed
            continue
        orientation[:, place], velocity[:, place] = [0.0, 0.0, 0.0, 1.0], 0.0
        for raw in joint.axes:  # innermost first
            axis, angle, rate = _unit(np.array(raw)), rng.uniform(-1.0, 1.0, count), rng.normal(size=count) * speed
            turn = _rotation(axis, angle)
            orientation[:, place] = multiply(turn, orientation[:, place])
            velocity[:, place] = rotate(turn, velocity[:, place]) + rate[:, None] * axis
    root = _random_root(character, count, rng, speed)
    return States(*root, orientation, velocity)


def _random_root(character: Character, count: int, rng: np.random.Generator, speed: float) -> tuple[np.ndarray, ...]:
    """Random pose and velocities of the root, as far as its joint allows."""
    if character.root_joint == "free":
        return (
            rng.normal(size=(count, 3)),
            _unit(rng.normal(size=(count, 4))),
            rng.normal(size=(count, 3)) * speed,
            rng.normal(size=(count, 3)) * speed,
        )
    x, yz = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 1.0])
    moves = float(character.root_joint == "planar")
    return (
        moves * yz * rng.normal(size=(count, 3)),
        _rotation(x, moves * rng.uniform(-1.0, 1.0, count)),
        moves * yz * speed * rng.normal(size=(count, 3)),
        moves * x * speed * rng.normal(size=(count, 3)),
    )


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
    axes = _unit(np.array(joint.axes, dtype=float))
    angles = 2.0 * np.arctan2(axes @ orientation[:3], orientation[3])
    if len(axes) == 1:
        return angles, axes @ angular_velocity
    turned = np.stack([rotate(_rotation(axes[1], angles[1:])[0], axes[0]), axes[1]])  # as they are in the parent
    return angles, turned @ angular_velocity


def _rotation(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Quaternions (N, 4) of turns by angles (N,) about a unit axis (3,)."""
    half = 0.5 * np.asarray(angle)[:, None]
    return np.concatenate([np.sin(half) * axis, np.cos(half)], axis=1)


def _inverse(quaternion: np.ndarray) -> np.ndarray:
    return quaternion * [-1.0, -1.0, -1.0, 1.0]


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
