"""What devices on a body look like: bars, drums at joints, straps, and the ends of cords; numbers only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, first_row
from warpmuscle.scene import Character, Force, Scene
from warpmuscle.scene.anatomy import far_end, joint_place, sides_of

ASIDE = 0.055  # m, of bars beside a joint, outwards
BAR, HUB, DRUM, STRAP, HOOK = 0.011, 0.024, 0.045, 0.009, 0.016  # m, radii
ALONG = 0.6  # of a segment, that a bar runs along
UPWARDS = 0.6  # m, of a strap
SHORTEST = 0.02  # m, of a bar


class Rod(NamedTuple):
    """A rod that is fixed to a body, round at its ends or flat."""

    body: str
    start: Floats  # (3,) m, in the body's frame
    end: Floats
    radius: float  # m
    flat: bool = False


def device_rods(scene: Scene) -> list[Rod]:
    """The devices of a scene without free parameters: springs and motors at joints, cords, and weight support."""
    rods: list[Rod] = []
    for force in scene.forces.values():
        if force.type in ("bilinear_spring", "cycle_torque") and force.joint in scene.character.joints:
            rods += _at_joint(scene.character, force)
        elif force.type == "joint_motor":
            rods += _between(scene.character, force)
        elif force.type == "weight_support":
            rods.append(Rod(force.body, np.zeros(3), np.array([0.0, UPWARDS, 0.0]), STRAP))
        elif force.type == "point_spring":
            for body, end in ((force.body, "first"), (force.other_body, "second")):
                place = np.array([first_number(force.parameters.get(f"{end}_{axis}", 0.0)) for axis in "xyz"])
                rods.append(Rod(body, place, place, HOOK))
    return rods


def _at_joint(character: Character, force: Force) -> list[Rod]:
    """Bars on both sides of a joint, and a hub, or the drum of a motor, outwards of it."""
    joint = character.joints[force.joint]
    side = sides_of(character)[joint.child]
    aside = np.array([{"left": 1.0, "right": -1.0, "middle": 0.0}[side] * ASIDE, 0.0, 0.0])
    above, below = joint_place(joint), first_row(joint.position_in_child)
    rods = []
    for body, begin, target in (
        (joint.parent, above, _upper_end(character, joint.parent)),
        (joint.child, below, _lower_end(character, joint.child, below)),
    ):
        if np.linalg.norm(target - begin) > SHORTEST:
            rods.append(Rod(body, begin + aside, begin + aside + ALONG * (target - begin), BAR))
    if force.type == "cycle_torque":
        return [*rods, Rod(joint.parent, above + 0.7 * aside, above + 1.5 * aside, DRUM, flat=True)]
    return [*rods, Rod(joint.parent, above + aside, above + aside, HUB)]


def _between(character: Character, force: Force) -> list[Rod]:
    """The drum of a motor where the second body hangs on the first one, across it; none if it does not."""
    carriers = {joint.child: joint for joint in character.joints.values()}
    body = force.other_body
    while body in carriers and carriers[body].parent != force.body:
        body = carriers[body].parent
    if body not in carriers:
        return []
    place, aside = joint_place(carriers[body]), np.array([ASIDE, 0.0, 0.0])
    return [Rod(force.body, place - 0.5 * aside, place + 0.5 * aside, DRUM, flat=True)]


def _upper_end(character: Character, body: str) -> Floats:
    """Where a segment begins: at its own joint, or at its centre of mass."""
    own = next((joint for joint in character.joints.values() if joint.child == body), None)
    return np.zeros(3) if own is None else np.asarray(first_row(own.position_in_child))


def _lower_end(character: Character, body: str, start: Floats) -> Floats:
    """Where a segment ends: at the next joint, or at the far end of its shapes, or behind its centre of mass."""
    ends = [joint_place(joint) for joint in character.joints.values() if joint.parent == body]
    ends = ends or [np.asarray(far_end(shape, start)) for shape in character.bodies[body].shapes]
    return max(ends, key=lambda end: float(np.linalg.norm(end - start))) if ends else -start
