"""What a scene says of bodies that push each other where they touch."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import FROM_0, Part

Pair = tuple[str, str]


class BodyContact(Part):
    """Contact of bodies with each other: their shapes as capsules, with a spring, a damper and friction.

    Boxes are the capsules inside them along their longest edge, as thick as their shortest one. Without `pairs`, those
    of a biped: each part of a leg and that of the other leg, each foot and the other shank, forearms and the trunk's
    bodies, forearms and the thigh of their side; but for pairs that a joint joins. A joint's limits, not contact, hold
    neighbours apart. The force is implicit over the step, so that no stiffness is unstable.
    """

    stiffness: Annotated[Number, "N/m", FROM_0] = 5.0e4  # 0 switches contact off
    damping: Annotated[Number, "N s/m", FROM_0] = 300.0
    tangential_damping: Annotated[Number, "N s/m", FROM_0] = 1.0e3  # up to the friction limit
    friction: Annotated[Number, "1", FROM_0] = 0.5
    pairs: list[Pair] = []  # bodies that push each other; if empty, those of a biped
