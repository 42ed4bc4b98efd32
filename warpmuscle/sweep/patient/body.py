"""What makes the body of a scene as large and as heavy as a patient's model, as changes of the scene."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import msgspec

from warpmuscle.core.errors import Error
from warpmuscle.core.number_rows import first_row
from warpmuscle.gait.pelvis_and_trunk import segments
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import joint_place, leg_joints
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.scaling import muscle_length_factors, scaled_segments

ALIKE = 0.005  # of a size or mass, below which a difference is none
AREA = 2.0 / 3.0  # power of the mass that strength grows with, as the area of muscles does


def sizes_of(scene: Scene) -> tuple[float, float]:
    """Lengths of thigh and shank, m, the mean of both legs of a numeric scene.

    Raises:
        Error: no legs with hip, knee and ankle.
    """
    thighs, shanks = [], []
    for side in (0, 1):
        joints = [scene.character.joints[name] for name in leg_joints(scene, side)]
        if len(joints) < 3:
            raise Error(f"{scene.name} has no hip, knee and ankle, whose distances are the sizes of a leg")
        thigh, shank = (
            math.dist(first_row(above.position_in_child), joint_place(below)) for above, below in pairwise(joints)
        )
        thighs.append(thigh)
        shanks.append(shank)
    return sum(thighs) / 2.0, sum(shanks) / 2.0


def trunk_is_pelvis(scene: Scene) -> bool:
    """Whether the trunk of a numeric scene cannot turn on its pelvis, so that the tilt of both is the trunk's."""
    bodies = segments(scene)
    above = [joint for joint in scene.character.joints.values() if joint.child == bodies.get("Trunk")]
    return not any(joint_type(joint).moves for joint in above)


def changes_to_size(walker: Scene, patient: Scene) -> dict[str, Any]:
    """Changes, by key, that give a numeric scene the sizes and the mass of a patient's model; none if it has them.

    Thighs and shanks get their own lengths, all other bodies the ratio of both together. Fibres and tendons follow the
    lengths of their paths with all joints at zero, so that both sides stay alike where the scene begins in a stride.
    Masses are multiplied alike so that they add up to the patient's, and strengths grow with the mass to the power 2/3.

    Raises:
        Error: one of both has no legs.
    """
    own, wanted = sizes_of(walker), sizes_of(patient)
    whole = sum(wanted) / sum(own)
    factors = dict.fromkeys(walker.character.bodies, whole)
    for side in (0, 1):
        hip, knee, _ = leg_joints(walker, side)
        for joint, before, after in ((hip, own[0], wanted[0]), (knee, own[1], wanted[1])):
            factors[walker.character.joints[joint].child] = after / before
    found: dict[str, Any] = {}
    if any(abs(factor - 1.0) > ALIKE for factor in factors.values()):
        found = {f"scale.{body}": {"factor": factor} for body, factor in factors.items()}
        straight = msgspec.structs.replace(
            walker, initial_state=msgspec.structs.replace(walker.initial_state, joints={})
        )
        longer = muscle_length_factors(straight, scaled_segments(straight, factors))
        found |= {key: {"factor": factor} for key, factor in longer.items()}
    else:
        factors = dict.fromkeys(factors, 1.0)
    bodies = walker.character.bodies
    scaled = sum(float(first_row([one.mass])[0]) * factors[name] ** 3 for name, one in bodies.items())
    heavier = body_mass(patient.character) / scaled
    if abs(heavier - 1.0) > ALIKE:
        found["character.bodies.*.mass"] = {"factor": heavier}
        found["character.bodies.*.inertia.*"] = {"factor": heavier}
    stronger = (body_mass(patient.character) / body_mass(walker.character)) ** AREA
    if abs(stronger - 1.0) > ALIKE and walker.character.muscles:
        found["character.muscles.*.f_max"] = {"factor": stronger}
    return found
