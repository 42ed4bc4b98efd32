"""SIMBICON in double precision, written down from its description, for one state at a time and as plainly as possible.

Torques act positively on the parent; quaternions are xyzw.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from biped import breadth_first, multiply, rotate
from random_states import States, body_order
from warpmuscle.scene import PD, Balance, Component, Controller, Curve, Feedback, Scene, Trajectory

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
NO_GAINS = PD(kp=0.0, kd=0.0, torque_limit=0.0, scale=(0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Motion:
    """Bodies in the world, by name, and what the controller derives from them."""

    center: dict[str, np.ndarray]  # m
    orientation: dict[str, np.ndarray]
    velocity: dict[str, np.ndarray]  # m/s
    angular: dict[str, np.ndarray]  # rad/s
    com: np.ndarray
    com_velocity: np.ndarray


def inverse(q: np.ndarray) -> np.ndarray:
    return q * [-1.0, -1.0, -1.0, 1.0]


def rotation(axis, angle: float) -> np.ndarray:
    axis = np.array(axis) / np.linalg.norm(axis)
    return np.array([*np.sin(angle / 2.0) * axis, np.cos(angle / 2.0)])


def heading(q: np.ndarray) -> np.ndarray:
    return np.array([0.0, q[1], 0.0, q[3]]) / np.hypot(q[1], q[3])


def motion(scene: Scene, states: States, index: int) -> Motion:
    """Poses and velocities of all bodies, from the root outwards."""
    character, root = scene.character, scene.character.root
    center, orientation = {root: states.root_position[index]}, {root: states.root_orientation[index]}
    velocity, angular = {root: states.root_velocity[index]}, {root: states.root_angular_velocity[index]}
    for place, name in enumerate(breadth_first(character)):
        joint = character.joints[name]
        p, c = joint.parent, joint.child
        orientation[c] = multiply(orientation[p], states.joint_orientation[index, place])
        angular[c] = angular[p] + rotate(orientation[p], states.joint_angular_velocity[index, place])
        in_parent = rotate(orientation[p], np.array(joint.position_in_parent))
        in_child = rotate(orientation[c], np.array(joint.position_in_child))
        center[c] = center[p] + in_parent - in_child
        velocity[c] = velocity[p] + np.cross(angular[p], in_parent) - np.cross(angular[c], in_child)
    mass = {name: character.bodies[name].mass for name in body_order(character)}
    com = sum(mass[name] * center[name] for name in mass) / sum(mass.values())
    com_velocity = sum(mass[name] * velocity[name] for name in mass) / sum(mass.values())
    return Motion(center, orientation, velocity, angular, com, com_velocity)


def curve(phase: list[float], value: list[float], x: float) -> float:
    """Catmull-Rom whose tangents are half the difference of the neighbours, whatever the spacing of the knots."""
    if not phase:
        return 0.0
    if x <= phase[0]:
        return value[0]
    if x >= phase[-1]:
        return value[-1]
    k = next(i for i in range(len(phase)) if phase[i] > x)
    s = (x - phase[k - 1]) / (phase[k] - phase[k - 1])
    m1 = 0.5 * (value[k] - value[max(k - 2, 0)])
    m2 = 0.5 * (value[min(k + 1, len(value) - 1)] - value[k - 1])
    return (
        value[k - 1] * (2 * s**3 - 3 * s**2 + 1)
        + m1 * (s**3 - 2 * s**2 + s)
        + value[k] * (-2 * s**3 + 3 * s**2)
        + m2 * (s**3 - s**2)
    )


def at(this: Curve | None, phase: float) -> float:
    return 0.0 if this is None else curve(this.phase, this.value, phase)


def feedback_angle(feedback: Feedback, d: np.ndarray, v: np.ndarray) -> float:
    axis = np.array(feedback.axis) / np.linalg.norm(feedback.axis)
    return feedback.cd * np.clip(d @ axis, *feedback.d_limits) + feedback.cv * np.clip(v @ axis, *feedback.v_limits)


def component_angle(component: Component, phase: float, stance: int, d: np.ndarray, v: np.ndarray) -> float:
    angle = curve(component.phase, component.angle, phase)
    if component.reverse_on == ("left", "right")[stance]:
        angle = -angle
    if component.feedback is not None:
        angle += feedback_angle(component.feedback, d, v)
    return angle


def joint_meant(name: str, stance: int) -> str:
    left_right = "lr"
    if name.startswith("SWING_"):
        return left_right[1 - stance] + name[6:]
    return left_right[stance] + name[7:] if name.startswith("STANCE_") else name


def set_points(balance: Balance | None, phase: float, stance: int) -> tuple[np.ndarray, np.ndarray]:
    if balance is None:
        return np.zeros(3), np.zeros(3)
    mirror = np.array([-1.0 if stance == 1 else 1.0, 0.0, 1.0])
    d = np.array([at(balance.distance_x, phase), 0.0, at(balance.distance_z, phase)])
    v = np.array([at(balance.velocity_x, phase), 0.0, at(balance.velocity_z, phase)])
    return mirror * d, mirror * v


def pd(q: np.ndarray, target: np.ndarray, velocity: np.ndarray, gains: PD, strength: float) -> np.ndarray:
    """PD torque in the frame that q, the target and the velocity are given in."""
    error = multiply(inverse(q), target)
    sine = np.linalg.norm(error[:3])
    spring = np.zeros(3)
    if sine > 1e-10:
        sign = 1.0 if error[3] >= 0.0 else -1.0
        spring = -gains.kp * sign * 2.0 * np.arcsin(min(sine, 1.0)) * error[:3] / sine
    torque = strength * (rotate(q, spring) + gains.kd * velocity)
    return rotate(q, clamped(rotate(inverse(q), torque) * np.array(gains.scale), gains))


def clamped(child_torque: np.ndarray, gains: PD) -> np.ndarray:
    bound = np.array(gains.scale) * gains.torque_limit
    return np.clip(child_torque, -bound, bound)


def control(
    scene: Scene, states: States, index: int, phase: float, stance: int, machine_state: int, foot_force: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Targets (J, 4) and torques (J, 3), world, of one state; foot_force (2, 3) of the left and the right foot."""
    controller, character = scene.controller, scene.character
    m, root, phase = motion(scene, states, index), scene.character.root, min(phase, 1.0)
    state = controller.states[machine_state]
    frame = heading(m.orientation[root])
    d = rotate(inverse(frame), m.com - m.center[controller.feet[stance]])
    v = rotate(inverse(frame), m.com_velocity)
    d0, v0 = set_points(state.balance, phase, stance)

    driven: dict[str, Trajectory] = {joint_meant(name, stance): t for name, t in state.trajectories.items()}
    targets = dict.fromkeys(("root", *character.joints), IDENTITY)
    strength = dict.fromkeys(targets, 1.0)
    for name, trajectory in driven.items():
        for part in trajectory.components:
            turn = rotation(part.axis, component_angle(part, phase, stance, d - d0, v - v0))
            targets[name] = multiply(turn, targets[name])
        if trajectory.strength is not None:
            strength[name] = at(trajectory.strength, phase)

    stance_hip, swing_hip = controller.hips[stance], controller.hips[1 - stance]
    torque = {}
    for name, joint in character.joints.items():
        gains = controller.pd.get(name, NO_GAINS)
        q, q_parent = m.orientation[joint.child], m.orientation[joint.parent]
        in_character_frame = name in driven and driven[name].frame == "character"
        if name == swing_hip or in_character_frame:
            target = multiply(frame, targets[name])
            torque[name] = pd(q, target, m.angular[joint.child], gains, strength[name])
        else:
            relative = rotate(inverse(q_parent), m.angular[joint.child] - m.angular[joint.parent])
            local = pd(multiply(inverse(q_parent), q), targets[name], relative, gains, strength[name])
            torque[name] = rotate(q_parent, local)

    _hips(controller, scene, m, torque, targets["root"], strength["root"], frame, d, stance, foot_force)
    limp = np.clip((m.center[root][1] - 0.2) / 0.2, 0.0, 1.0)
    names = breadth_first(character)
    assert {stance_hip, swing_hip} <= set(names)
    return np.array([targets[name] for name in names]), np.array([torque[name] * limp for name in names])


def _hips(
    controller: Controller, scene: Scene, m: Motion, torque: dict[str, np.ndarray], root_target: np.ndarray,
    root_strength: float, frame: np.ndarray, d: np.ndarray, stance: int, foot_force: np.ndarray,
) -> None:  # fmt: skip
    """Give the hips what the root lacks, damp the yaw of the stance hip, and keep both within their limits."""
    root, joints = scene.character.root, scene.character.joints
    stance_hip, swing_hip = controller.hips[stance], controller.hips[1 - stance]
    on_stance, on_swing = foot_force[stance, 1], foot_force[1 - stance, 1]
    if on_stance + on_swing == 0.0:
        share, root_strength = -1.0, 0.0
    else:
        share = on_stance / (on_stance + on_swing)
    facing = rotation((0.0, 1.0, 0.0), controller.desired_heading) if controller.heading_control else frame
    gains = controller.pd.get("root", NO_GAINS)
    missing = -pd(m.orientation[root], multiply(facing, root_target), m.angular[root], gains, 1.0)
    missing -= sum(torque[name] for name, joint in joints.items() if joint.parent == root)
    missing += rotate(frame, np.array([0.0, 0.0, controller.root_predictive_torque_scale * 9.8 * d[0]]))
    root_strength = np.clip(root_strength, 0.0, 1.0)
    torque[stance_hip] = torque[stance_hip] + share * root_strength * missing
    torque[swing_hip] = torque[swing_hip] + (1.0 - share) * root_strength * missing
    if controller.stance_hip_damping > 0.0:
        largest = controller.stance_hip_max_velocity
        yaw = np.clip(m.angular[root][1] - m.angular[joints[stance_hip].child][1], -largest, largest)
        torque[stance_hip] = torque[stance_hip] - [0.0, controller.stance_hip_damping * yaw * abs(yaw), 0.0]
    for name in (stance_hip, swing_hip):
        q = m.orientation[joints[name].child]
        torque[name] = rotate(q, clamped(rotate(inverse(q), torque[name]), controller.pd.get(name, NO_GAINS)))
