"""Moment arms of muscles over the range of a joint, and muscles that cannot act on a joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.html_table import Tabulated
from warpmuscle.core.pose import rotate
from warpmuscle.model.build import start_of
from warpmuscle.scene import Joint, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.trusted_code import without_code
from warpmuscle.simulation.stages import Stages

USELESS = 1.0e-3  # m: a muscle whose moment arm stays below cannot act on a joint
DEFAULT_RANGE = (-0.6, 0.6)  # rad, of a joint without limits
SAMPLES = 7  # of the range of each degree of freedom


@dataclass(frozen=True, repr=False)
class MomentArms(Tabulated):
    """Moment arms -dl/dq of all muscles that act on a joint, over the angle of one of its degrees of freedom."""

    joint: str
    axis: int
    angle: Floats  # (n,) rad
    muscles: tuple[str, ...]
    arm: Floats  # (n, muscles) m, positive if the muscle's tension turns the child towards greater angles


def moment_arms(scene: Scene, joint: str, axis: int, angles: Floats) -> MomentArms:
    """Moment arms about a degree of freedom of a joint; all else is as in the initial state.

    Args:
        scene: checked scene; free parameters count with their start values.
        joint: its name. axis: which of its degrees of freedom; of a ball joint x, y or z of the child.
        angles: (n,) rad; of a ball joint about that axis from the reference pose.
    """
    return _moment_arms(scene, [(joint, axis, np.asarray(angles, dtype=float))])[0]


def _moment_arms(scene: Scene, wanted: Sequence[tuple[str, int, Floats]]) -> list[MomentArms]:
    """Moment arms about several joints' degrees of freedom, each at its angles, computed as one batch."""
    scene = without_code(at_start(scene))
    ends = np.cumsum([len(angles) for _, _, angles in wanted])
    stages = Stages(scene, int(ends[-1]), "cpu")
    stages.state.coordinates.assign(np.concatenate([_poses(scene, stages, *one) for one in wanted]))
    orientation, paths = stages.forward_kinematics()["orientation"].astype(float), stages.muscle_paths()
    coordinates, names, muscles = stages.state.coordinates.numpy(), stages.names, list(scene.character.muscles)
    found = []
    for (joint, axis, angles), end in zip(wanted, ends, strict=True):
        here, body = slice(end - len(angles), end), names.body_of_joint(joint)
        own = [k for k, crossed in enumerate(paths.joint) if names.joints[crossed] == joint]
        q = coordinates[here, names.joint_coordinates(body)].astype(float)
        along = joint_type(scene.character.joints[joint]).pulled_about(scene.character.joints[joint], q)[axis]
        about = rotate(orientation[here, names.parents[body]], along)
        arm = _along(paths.moment_arm[here][:, own], about)
        found.append(MomentArms(joint, axis, angles, tuple(muscles[paths.muscle[k]] for k in own), arm))
    return found


def muscle_geometry(scene: Scene, coordinates: Floats) -> tuple[Floats, Floats]:
    """Lengths of all muscles' paths (n, M), m, and their moment arms (n, M, S), m, about every degree of freedom.

    Args:
        scene: checked scene; free parameters count with their start values. coordinates: (n, C), see `Rollout.state`.
    """
    scene = without_code(at_start(scene))
    stages = Stages(scene, len(coordinates), "cpu")
    stages.state.coordinates.assign(coordinates.astype(np.float32))
    kinematics, paths = stages.forward_kinematics(), stages.muscle_paths()
    names = stages.names
    arm = np.zeros((len(coordinates), len(scene.character.muscles), names.speeds))
    for number, name in enumerate(names.joints, 1):
        own = [k for k, crossed in enumerate(paths.joint) if crossed == number - 1]
        if not own:
            continue
        joint = scene.character.joints[name]
        parent = kinematics["orientation"].astype(float)[:, names.parents[number]]
        q = np.asarray(coordinates, float)[:, names.joint_coordinates(number)]
        for axis, along in enumerate(joint_type(joint).pulled_about(joint, q)):
            arm[:, [paths.muscle[k] for k in own], names.speed_start[number] + axis] = _along(
                paths.moment_arm[:, own], rotate(parent, along)
            )
    return paths.length.astype(float), arm


def useless_muscles(scene: Scene) -> list[tuple[str, str, float]]:
    """Muscles that cross a joint but cannot act on it, with the joint and the largest moment arm over its range, m."""
    wanted = [
        (name, axis, np.linspace(*joint_range(joint, axis), SAMPLES))
        for name, joint in scene.character.joints.items()
        for axis in range(len(joint_type(joint).speeds))
    ]
    greatest: dict[tuple[str, str], float] = {}
    for arms in _moment_arms(scene, wanted) if wanted else []:
        for muscle, arm in zip(arms.muscles, np.abs(arms.arm).max(axis=0), strict=True):
            key = muscle, arms.joint
            greatest[key] = max(greatest.get(key, 0.0), float(arm))
    return [(muscle, joint, arm) for (muscle, joint), arm in greatest.items() if arm < USELESS]


def _along(moment_arm: Floats, about: Floats) -> Floats:
    """Moment arms (n, crossings, 3) along axes (n, 3): a tension F turns the child by -F r."""
    return np.asarray(-np.einsum("nci,ni->nc", moment_arm.astype(float), about))


def joint_range(joint: Joint, axis: int) -> tuple[float, float]:
    """Range of a degree of freedom, rad; the limits of a ball joint are about other axes and do not count."""
    return joint_type(joint).range(joint, axis) or DEFAULT_RANGE


def _poses(scene: Scene, stages: Stages, joint: str, axis: int, angles: Floats) -> Floats:
    """Coordinates (n, C) of the initial state but for one degree of freedom."""
    names = stages.names
    poses = np.repeat(start_of(scene, names).coordinates, len(angles), axis=0)
    body = names.body_of_joint(joint)
    own = names.joint_coordinates(body)
    poses[:, own] = joint_type(scene.character.joints[joint]).posed(axis, np.asarray(angles, float), poses[:, own])
    return poses.astype(np.float32)
