"""The biped of the original SIMBICON program, typed by hand, and its recordings; no reader of the package is used."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Body, Box, Capsule, Character, Joint, Shape, Sphere

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def biped() -> Character:
    """15 bodies of 70.4 kg, 14 joints, 34 degrees of freedom; named as in the original's files."""
    thigh = Capsule((0.0, 0.12, 0.0), (0.0, -0.26, 0.0), 0.05)
    shank = Capsule((0.0, 0.12, 0.0), (0.0, -0.2, 0.0), 0.05)
    arm = Capsule((-0.15, 0.0, 0.0), (0.15, 0.0, 0.0), 0.05)
    bodies = {
        "pelvis": _body(12.9, (0.0705, 0.11, 0.13), Sphere((0.0, -0.075, 0.0), 0.12)),
        "torso": _body(22.5, (0.34, 0.21, 0.46), Sphere((0.0, 0.0, 0.01), 0.11)),
        "head": _body(5.2, (0.04, 0.02, 0.042), Sphere((0.0, 0.04, 0.0), 0.11)),
    }
    joints = {
        "pelvis_torso": Joint("ball", "pelvis", "torso", (0.0, 0.17, -0.035), (0.0, -0.23, -0.01), [X, Y]),
        "torso_head": Joint("ball", "torso", "head", (0.0, 0.1, 0.0), (0.0, -0.16, -0.025), [X, Y]),
    }
    for side, sign in (("l", 1.0), ("r", -1.0)):
        bodies |= {
            f"{side}Upperarm": _body(2.2, (0.005, 0.02, 0.02), arm),
            f"{side}Lowerarm": _body(1.7, (0.0024, 0.025, 0.025), arm),
            f"{side}Upperleg": _body(6.6, (0.15, 0.022, 0.15), thigh),
            f"{side}Lowerleg": _body(3.2, (0.055, 0.007, 0.055), shank),
            f"{side}Foot": _body(1.0, (0.007, 0.008, 0.002), Box((-0.025, -0.033, -0.09), (0.025, 0.005, 0.055))),
            f"{side}Toes": _body(0.2, (0.002, 0.002, 0.0005), Sphere((0.0, -0.005, 0.025), 0.01)),
        }
        joints |= _limb_joints(side, sign)
    return Character("pelvis", bodies, joints)


def _body(mass: float, inertia: tuple[float, float, float], shape: Shape) -> Body:
    return Body(mass, inertia, [shape])


def _limb_joints(side: str, sign: float) -> dict[str, Joint]:
    """Joints of one arm and one leg; x points to the left, so `sign` is +1 on that side."""

    def between(kind: str, parent: str, child: str, in_parent, in_child, *axes) -> Joint:
        parent = parent if parent in ("pelvis", "torso") else side + parent
        return Joint(kind, parent, side + child, in_parent, in_child, list(axes))

    return {
        f"{side}Shoulder": between("ball", "torso", "Upperarm", (0.2 * sign, 0.07, 0.02), (-0.17 * sign, 0, 0), Z, X),
        f"{side}Elbow": between(
            "hinge", "Upperarm", "Lowerarm", (0.175 * sign, 0.0, 0.006), (-0.215 * sign, 0.0, 0.0), (0.0, sign, 0.0)
        ),
        f"{side}Hip": between("ball", "pelvis", "Upperleg", (0.1 * sign, -0.05, 0.0), (0.0, 0.21, 0.0), X, Y),
        f"{side}Knee": between("hinge", "Upperleg", "Lowerleg", (0.0, -0.26, 0.0), (0.0, 0.21, 0.0), X),
        f"{side}Ankle": between("universal", "Lowerleg", "Foot", (0.0, -0.25, 0.01), (0.0, 0.02, -0.04), X, Z),
        f"{side}ToeJoint": between("hinge", "Foot", "Toes", (0.0, -0.02, 0.05), (0.0, 0.0, -0.025), X),
    }


def breadth_first(character: Character) -> list[str]:
    """Names of the joints from the root outwards."""
    bodies, names = [character.root], []
    for body in bodies:
        for name, joint in character.joints.items():
            if joint.parent == body:
                names.append(name)
                bodies.append(joint.child)
    return names


def load_recording(path: Path, character: Character) -> Recording:
    """A recording of the original program, with body poses by forward kinematics; below full rate, targets are missing
    and set to the orientations."""
    with np.load(path) as file:
        data = {name: file[name] for name in file.files}
    names = tuple(str(name) for name in data["joint_names"])
    arrays = {
        "time": data["t"],
        "phase": data["phi"],
        "stance": data["stance"].astype(np.int32),
        "state": data["fsm_state"].astype(np.int32),
        "root_position": data["root_pos"],
        "root_orientation": xyzw(data["root_quat"]),
        "root_velocity": data["root_vel"],
        "root_angular_velocity": data["root_angvel"],
        "joint_orientation": xyzw(data["joint_quat"]),
        "joint_angular_velocity": data["joint_angvel"],
        "joint_torque": data["joint_torque"],
        "joint_target": xyzw(data["desired_quat"] if "desired_quat" in data else data["joint_quat"]),
        "com": data["com"],
        "com_velocity": data["com_vel"],
        "foot_force_left": data["foot_force_l"],
        "foot_force_right": data["foot_force_r"],
    }
    poses = forward_kinematics(
        character, arrays["root_position"], arrays["root_orientation"],
        dict(zip(names, np.moveaxis(arrays["joint_orientation"], 1, 0), strict=True)),
    )  # fmt: skip
    body_names = tuple(poses)
    arrays["body_position"] = np.stack([poses[name][0] for name in body_names], axis=1)
    arrays["body_orientation"] = np.stack([poses[name][1] for name in body_names], axis=1)
    return Recording.of(arrays, names, body_names)


def forward_kinematics(
    character: Character, root_position: np.ndarray, root_orientation: np.ndarray, joints: Mapping[str, np.ndarray]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Position (F, 3) and orientation (F, 4) xyzw of every body, from those of the root and of joints (F, 4)."""
    poses = {character.root: (root_position, root_orientation)}
    for name, orientation in joints.items():
        joint = character.joints[name]
        position, parent = poses[joint.parent]
        child = multiply(parent, orientation)
        origin = position + rotate(parent, np.array(joint.position_in_parent))
        poses[joint.child] = (origin - rotate(child, np.array(joint.position_in_child)), child)
    return poses


def xyzw(wxyz: np.ndarray) -> np.ndarray:
    """Quaternions with the scalar last."""
    return np.roll(wxyz, -1, axis=-1)


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Hamilton product of quaternions (..., 4) xyzw: first b, then a."""
    vector = a[..., 3:] * b[..., :3] + b[..., 3:] * a[..., :3] + np.cross(a[..., :3], b[..., :3])
    scalar = a[..., 3:] * b[..., 3:] - np.sum(a[..., :3] * b[..., :3], axis=-1, keepdims=True)
    return np.concatenate([vector, scalar], axis=-1)


def rotate(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) turned by quaternions (..., 4) xyzw."""
    cross = 2.0 * np.cross(quaternion[..., :3], vector)
    return vector + quaternion[..., 3:] * cross + np.cross(quaternion[..., :3], cross)


def random_recording(frames: int = 200, joints: int = 3, seed: int = 0, muscles: int = 0) -> Recording:
    """A recording of the right shapes, filled with random numbers."""
    rng = np.random.default_rng(seed)
    counts = {"frame": frames, "joint": joints, "body": joints + 1, "muscle": muscles, "coordinate": 0, "speed": 0}
    counts |= {"joint_angle": 0, "controller_value": 0, "recorded": 0}
    arrays = {
        name: rng.random([counts.get(axis, len(axis.split())) for axis in quantity.axes])
        for name, quantity in QUANTITIES.items()
    }
    for name, quantity in QUANTITIES.items():
        if quantity.axes[-1] == "x y z w":
            arrays[name] /= np.linalg.norm(arrays[name], axis=-1, keepdims=True)
    arrays |= {"stance": np.zeros(frames, dtype=np.int32), "state": np.zeros(frames, dtype=np.int32)}
    arrays["time"] = np.arange(frames) / max(frames, 1)
    names = [f"part{i}" for i in range(joints + 1)]
    return Recording.of(arrays, tuple(names[1:]), tuple(names), tuple(f"muscle{i}" for i in range(muscles)))
