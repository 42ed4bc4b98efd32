"""Rib cage and shoulder blades of models whose bodies are called so, as those of a shoulder are; numbers only.

Such a model has arms on one side as a rule, and its trunk may have no mass: the joints of its collar bones and where
its muscles end are all that there is to go by.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene import Character
from warpmuscle.scene.anatomy import Side, joint_place
from warpmuscle.scene.initial_pose import plain_vector
from warpmuscle.scene.masses import massless
from warpmuscle.view.bones.named import named_role
from warpmuscle.view.bones.skeleton import trunk_bones
from warpmuscle.view.hulls import Mesh, Seeds, rounded_hull

# All m, of a person of 75 kg, whose upper arm is so long.
UPPER_ARM = 0.3
BESIDE_NOTCH = 0.025  # of a collar bone's joint, from the middle of the breastbone's upper end
TALL, NECK = 0.45, (0.0, 0.055, -0.09)  # of spine and loin; of the neck's joint, from there
SHOULDER = 0.175, -0.02, -0.055  # from there, to the left
BLADE = 0.004  # how thick a shoulder blade is at its edges, half
FEWEST = 4  # ends of muscles that a blade has


class RibCage(NamedTuple):
    """Places in the frame of a rib cage, m."""

    loin: Floats
    neck: Floats
    shoulders: list[Floats]  # (3,) left and right
    drawn: list[Floats]  # those of them where the model has no bodies of its own
    scale: float


def rib_cage(character: Character, body: str, sides: Mapping[str, Side]) -> RibCage | None:
    """Where a rib cage is, of a body that is called so and that collar bones hang on, or of a lone arm's; else None."""
    joints = character.joints.values()
    if (lone := _cage_of_arm(character, body, sides)) is not None:
        return lone
    collars = [one for one in joints if one.parent == body and named_role(one.child) == "collar bone"]
    if named_role(body) != "rib cage" or not collars:
        return None
    scale, place = _scale(character), joint_place(collars[0])
    sign = {"left": 1.0, "right": -1.0}.get(sides[collars[0].child], float(np.sign(place[0]) or -1.0))
    notch = place - np.array([sign * BESIDE_NOTCH * scale, 0.0, 0.0])
    neck = notch + scale * np.array(NECK)
    shoulders = {way: notch + scale * np.array(SHOULDER) * [way, 1.0, 1.0] for way in (1.0, -1.0)}
    drawn = [shoulders[-sign]] if len(collars) == 1 else []
    return RibCage(neck - [0.0, TALL * scale, 0.0], neck, list(shoulders.values()), drawn, scale)


def _cage_of_arm(character: Character, body: str, sides: Mapping[str, Side]) -> RibCage | None:
    """The rib cage of a body without mass and shapes on which an upper arm and muscles hang, and nothing else."""
    arms = [joint for joint in character.joints.values() if joint.parent == body]
    alone = len(arms) == 1 and named_role(arms[0].child) == "upper arm"
    if not alone or not massless(character.bodies[body]) or character.bodies[body].shapes:
        return None
    if not any(True for _ in _muscle_ends(character, body)):
        return None
    scale, shoulder = _scale(character), joint_place(arms[0])
    sign = -1.0 if sides[arms[0].child] == "right" else 1.0
    notch = shoulder - scale * np.array(SHOULDER) * [sign, 1.0, 1.0]
    neck = notch + scale * np.array(NECK)
    shoulders: list[Floats] = [notch + scale * np.array(SHOULDER) * [way, 1.0, 1.0] for way in (1.0, -1.0)]
    return RibCage(neck - [0.0, TALL * scale, 0.0], neck, shoulders, shoulders, scale)


def rib_cage_bones(cage: RibCage) -> Mesh:
    """Spine, ribs and breastbone, and collar bone and shoulder blade of a side where the model has none."""
    return trunk_bones(cage.loin, cage.neck, cage.drawn, cage.scale)


def shoulder_blade(character: Character, body: str) -> Mesh | None:
    """The hull of a shoulder's joint and of where muscles end on a body; None where these are few."""
    joints = [joint_place(joint) for joint in character.joints.values() if joint.parent == body]
    ends = [*joints, *_muscle_ends(character, body)]
    if len(ends) < FEWEST + len(joints):
        return None
    return rounded_hull(Seeds(np.array(ends), np.full(len(ends), BLADE * _scale(character))))


def _muscle_ends(character: Character, body: str) -> Iterable[Floats]:
    for muscle in character.muscles.values():
        for point in (muscle.path[0], muscle.path[-1]) if muscle.path else ():
            if point.body == body and not point.motion:
                yield np.asarray(point.place(), dtype=np.float64)


def _scale(character: Character) -> float:
    """How long the upper arm is in that of a person of 75 kg: the mass of an arm alone does not tell."""
    joints = character.joints.values()
    for joint in joints:
        if named_role(joint.child) == "upper arm":
            for below in (one for one in joints if one.parent == joint.child):
                length = float(np.linalg.norm(joint_place(below) - plain_vector(joint.position_in_child)))
                if length > 0.3 * UPPER_ARM:
                    return float(np.clip(length / UPPER_ARM, 0.3, 1.4))
    return 1.0
