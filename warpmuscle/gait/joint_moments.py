"""Moments and powers of hip, knee and ankle in the sagittal plane, beside those of people."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import conjugate, rotate
from warpmuscle.gait.cycles import PERCENT, Strides, leg_angles, over_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.joint_stops import stop_torques
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.norms import FLEXION
from warpmuscle.scene.people.fukuchi import Sampled
from warpmuscle.scene.people.pinzone import MOMENTS, PELVIS, POWERS

JOINTS = ("Hip", "Knee", "Ankle")
PEOPLE = MOMENTS | POWERS | PELVIS
# Moments that are measures: the curve, and the percent of the gait cycle.
MOMENTS_AT = {
    "hip moment in loading": ("Hip moment", 15.0),
    "knee moment in loading": ("Knee moment", 15.0),
    "knee moment before push-off": ("Knee moment", 50.0),
}
Curves = dict[str, dict[str, Floats]]  # by name and side


def leg_moments(recording: Recording, scene: Scene) -> Curves:
    """Internal moments (F,) of hip, knee and ankle, N m/kg of the body; of extensors and plantarflexors positive.

    What muscles, actuators and the joints' stops did over each step, about the parent's mediolateral axis: a person's
    moment, which follows from motion and ground forces, has what bones and ligaments bear in it, too.

    Raises:
        Error: no legs, or legs of fewer than three joints.
    """
    leg_angles(recording, scene)
    mass = body_mass(scene.character)
    found: Curves = {f"{name} moment": {} for name in JOINTS}
    for number, side in enumerate(SIDES):
        for name, joint, sign in zip(JOINTS, leg_joints(scene, number), FLEXION, strict=True):
            index = recording.joint_names.index(joint)
            parent = recording.body_names.index(scene.character.joints[joint].parent)
            torque = rotate(conjugate(recording.body_orientation[:, parent]), recording.joint_torque[:, index])
            torque = torque + stop_torques(recording, scene, joint)
            found[f"{name} moment"][side] = np.asarray(sign * torque[:, 0] / mass, dtype=float)
    return found


def leg_powers(recording: Recording, scene: Scene) -> Curves:
    """Powers (F,) of these moments, W/kg: positive where a joint gives energy to the body.

    Raises:
        Error: no legs, or legs of fewer than three joints.
    """
    found: Curves = {f"{name} power": {} for name in JOINTS}
    moments = leg_moments(recording, scene)
    for number, side in enumerate(SIDES):
        for name, joint, sign in zip(JOINTS, leg_joints(scene, number), FLEXION, strict=True):
            index = recording.joint_names.index(joint)
            flexing = sign * recording.joint_angular_velocity[:, index, 0].astype(float)
            found[f"{name} power"][side] = -moments[f"{name} moment"][side] * flexing
    return found


def mean_curves(recording: Recording, of_sides: dict[str, Floats], cycles: dict[str, Strides]) -> list[Floats]:
    """The mean curve (101,) of each side over its gait cycles."""
    return [over_strides(recording.time, of_sides[side], cycles[side]).mean(axis=0) for side in SIDES]


def from_people(name: str, curves: list[Floats], people: Mapping[str, Sampled] = PEOPLE) -> float:
    """Mean distance of both sides' curves (101,) from people's, in their mean standard deviation."""
    norm = people[name]
    mean, deviation = norm.mean(PERCENT), norm.sd(PERCENT).mean()
    return float(np.mean([np.abs(curve - mean).mean() for curve in curves]) / deviation)


def likeness(name: str, curves: list[Floats]) -> float:
    """Correlation of the mean of both sides' curves (101,) with people's; 0 of one that does not change."""
    curve, mean = np.mean(curves, axis=0), PEOPLE[name].mean(PERCENT)
    if curve.std() < 1e-9:
        return 0.0
    return float(np.corrcoef(curve, mean)[0, 1])
