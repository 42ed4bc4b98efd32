"""A recorded motion by degrees of freedom: angles and lengths by name, of root and joints.

The root has the coordinates that OpenSim's models have (see `scene.opensim_root.usual_root`): `pelvis_tilt`,
`pelvis_list`, `pelvis_rotation`, and `pelvis_tx` forward, `pelvis_ty` up, `pelvis_tz` to the right. A ball joint has
three angles, of turns about the child's x, then y, then z axis (intrinsic); a hinge or universal joint has its own, a
slide its position. Names are the joint's, with `_x`, `_y`, `_z` or `_a`, `_b` behind it. So a motion fits the `.osim`
file that is written of its scene. A scene made of an OpenSim model has that model's coordinates instead, locked and
coupled ones among them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import normalized
from warpmuscle.results.joint_poses import joint_angles
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import BallCoordinates, OpenSim, Scene
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.displacement import rates
from warpmuscle.scene.opensim_root import root_values, usual_root
from warpmuscle.scene.parameters import leaves, rebuilt


class Degree(NamedTuple):
    """A degree of freedom over F frames."""

    name: str
    unit: str  # rad or m
    values: Floats  # (F,)


def degrees_of_freedom(motion: Recording, scene: Scene, breaks: ArrayLike = ()) -> list[Degree]:
    """All degrees of freedom of a motion, those of the root first.

    Args:
        scene: without free parameters, of the same character.
        breaks: frames at which other motions begin; angles are continuous from frame to frame but there.
    """
    if scene.opensim is not None:
        return _of_model(motion, scene, scene.opensim, breaks)
    root = usual_root(scene.character)
    values = root_values(root, np.asarray(motion.root_position, np.float64), motion.root_orientation, breaks)
    turns = 0 if root.root is None else len(root.root.rotations)
    found = _columns(root.root_coordinates[:turns], "rad", values[:, :turns])
    found += _columns(root.root_coordinates[turns:], "m", values[:, turns:])
    for name in motion.joint_names:
        joint = scene.character.joints[name]
        entry = joint_type(joint)
        names = [f"{name}_{word}".rstrip("_") for word in entry.angles]
        found += _columns(names, entry.unit(joint), joint_angles(motion, scene.character, name, breaks))
    return found


def with_joint_angles(motion: Recording, scene: Scene, instance: int = 0) -> Recording:
    """The motion with its angles by name.

    Args:
        scene: of the motion; its numbers are floats, or (instances,) arrays with one value an instance.
        instance: which one moved.
    """
    joints = rebuilt(scene.character.joints, _row(instance))
    plain = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, joints=joints))
    angles = [degree for degree in degrees_of_freedom(motion, plain) if degree.unit == "rad"]
    values = np.stack([degree.values for degree in angles], axis=1) if angles else np.zeros((motion.frames, 0))
    return replace(motion, joint_angle=values, joint_angle_names=tuple(degree.name for degree in angles))


def with_angles_of_all(motions: Sequence[Recording], scene: Scene, instances: Sequence[int]) -> list[Recording]:
    """The same of several motions of a batch, at once where their joints are the same.

    Args:
        instances: which one moved, of each motion.
    """
    own = any(isinstance(leaf, np.ndarray) for _, leaf in leaves(scene.character.joints))
    if own or len(motions) < 2 or any(motion.missing for motion in motions):
        return [with_joint_angles(motion, scene, instance) for motion, instance in zip(motions, instances, strict=True)]
    arrays: dict[str, Any] = {name: np.concatenate([motion[name] for motion in motions]) for name in QUANTITIES}
    together = replace(motions[0], **arrays)
    breaks = np.cumsum([motion.frames for motion in motions])[:-1]
    angles = [degree for degree in degrees_of_freedom(together, scene, breaks) if degree.unit == "rad"]
    values = np.stack([degree.values for degree in angles], axis=1) if angles else np.zeros((together.frames, 0))
    names = tuple(degree.name for degree in angles)
    return [
        replace(motion, joint_angle=np.ascontiguousarray(part), joint_angle_names=names)
        for motion, part in zip(motions, np.split(values, breaks), strict=True)
    ]


def _row(instance: int) -> Callable[[str, Any], Any]:
    """Takes the value of one instance where there is one for each."""
    return lambda _, leaf: float(leaf[min(instance, len(leaf) - 1)]) if isinstance(leaf, np.ndarray) else leaf


def _columns(names: list[str], unit: str, values: Floats) -> list[Degree]:
    return [Degree(name, unit, values[:, k]) for k, name in enumerate(names)]


def _of_model(motion: Recording, scene: Scene, opensim: OpenSim, breaks: ArrayLike) -> list[Degree]:
    """The coordinates of an OpenSim model."""
    root = root_values(opensim, np.asarray(motion.root_position, np.float64), motion.root_orientation, breaks)
    values: dict[str, Floats] = dict(zip(opensim.root_coordinates, root.T, strict=True))
    for name in motion.joint_names:
        if name in opensim.balls:
            values |= _of_ball(motion, scene, name, opensim.balls[name])
        elif name in motion.coordinate_names:
            values[name] = np.asarray(motion.coordinate[:, motion.coordinate_names.index(name)], np.float64)
        elif len(joint_type(scene.character.joints[name]).angles) == 1:
            values[name] = joint_angles(motion, scene.character, name, breaks)[:, 0]
    for name, coupling in opensim.couplers.items():
        values[name] = rates(coupling, values[coupling.joint])[0]
    values |= {name: np.full(motion.frames, value) for name, value in opensim.locked.items()}
    return [Degree(name, "rad" if name in opensim.angles else "m", array) for name, array in values.items()]


def _of_ball(motion: Recording, scene: Scene, name: str, ball: BallCoordinates) -> dict[str, Floats]:
    """Coordinates of a model, (F,) rad each, that are angles of a ball joint here."""
    joint = scene.character.joints[name]
    turned = normalized(motion.joint_orientation[:, motion.joint_names.index(name)])
    first, second, third = joint_type(joint).angles_of(joint, turned).T
    return dict(zip(ball.names, (first, -second if ball.turned_round else second, third), strict=True))
