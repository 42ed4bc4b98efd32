"""Moment arms of muscles over the range of a joint, and muscles that cannot act on a joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.core.pose import rotate
from warpmuscle.model.bodies import joint_axes
from warpmuscle.model.build import start_of
from warpmuscle.scene import Joint, Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.topology import SPEEDS
from warpmuscle.scene.trusted_code import without_code
from warpmuscle.simulation.stages import MusclePaths, Stages

USELESS = 1.0e-3  # m: a muscle whose moment arm stays below cannot act on a joint
DEFAULT_RANGE = (-0.6, 0.6)  # rad, of a joint without limits
SAMPLES = 7  # of the range of each degree of freedom


@dataclass(frozen=True)
class MomentArms:
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
    scene = without_code(substitute(scene, start_values(scene)))
    stages = Stages(scene, len(angles), "cpu")
    stages.state.coordinates.assign(_poses(scene, stages, joint, axis, angles))
    body = stages.names.body_of_joint(joint)
    kinematics, paths = stages.forward_kinematics(), stages.muscle_paths()
    own = [k for k, crossed in enumerate(paths.joint) if stages.names.joints[crossed] == joint]
    orientation = kinematics["orientation"].astype(float)
    about = _world_axis(
        scene.character.joints[joint], axis, orientation[:, body], orientation[:, stages.names.parents[body]]
    )
    names = list(scene.character.muscles)
    return MomentArms(
        joint,
        axis,
        np.asarray(angles, dtype=float),
        tuple(names[paths.muscle[k]] for k in own),
        _along(paths, own, about),
    )


def useless_muscles(scene: Scene) -> list[tuple[str, str, float]]:
    """Muscles that cross a joint but cannot act on it, with the joint and the greatest moment arm over its range, m."""
    found: list[tuple[str, str, float]] = []
    for name, joint in scene.character.joints.items():
        greatest: dict[str, float] = {}
        for axis in range(SPEEDS[joint.type]):
            arms = moment_arms(scene, name, axis, np.linspace(*joint_range(joint, axis), SAMPLES))
            for muscle, arm in zip(arms.muscles, np.abs(arms.arm).max(axis=0), strict=True):
                greatest[muscle] = max(greatest.get(muscle, 0.0), float(arm))
        found.extend((muscle, name, arm) for muscle, arm in greatest.items() if arm < USELESS)
    return found


def _along(paths: MusclePaths, crossings: list[int], about: Floats) -> Floats:
    """Moment arms of some crossings about axes (n, 3): a tension F turns the child by -F r."""
    return np.asarray(-np.einsum("nci,ni->nc", paths.moment_arm[:, crossings].astype(float), about))


def joint_range(joint: Joint, axis: int) -> tuple[float, float]:
    """Range of a degree of freedom, rad; the limits of a ball joint are about other axes and do not count."""
    if joint.type == "ball" or not joint.limits:
        return DEFAULT_RANGE
    low, high = (float(rows(number)[0]) for number in joint.limits[axis])
    return low, high


def _poses(scene: Scene, stages: Stages, joint: str, axis: int, angles: Floats) -> Floats:
    """Coordinates (n, C) of the initial state but for one degree of freedom."""
    names = stages.names
    poses = np.repeat(start_of(scene, names).coordinates, len(angles), axis=0)
    first = names.coordinate_start[names.body_of_joint(joint)]
    if scene.character.joints[joint].type == "ball":
        half = 0.5 * np.asarray(angles, dtype=float)
        poses[:, first : first + 4] = 0.0
        poses[:, first + axis] = np.sin(half)
        poses[:, first + 3] = np.cos(half)
    else:
        poses[:, first + axis] = angles
    return poses.astype(np.float32)


def _world_axis(joint: Joint, axis: int, child: Floats, parent: Floats) -> Floats:
    """World axes (n, 3) of a degree of freedom, from the orientations (n, 4) of child and parent."""
    if joint.type == "ball":
        return rotate(child, np.eye(3)[axis])
    a, b = joint_axes(joint)
    return rotate(parent, b) if axis == 1 else rotate(child, a)
