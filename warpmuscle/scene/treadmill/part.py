"""What a scene says of ground that moves along itself."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import Part


class Treadmill(Part):
    """Ground that moves along itself: a treadmill with a belt for each side, or a platform that shifts.

    The belts run backwards, and what touches them takes the velocity of the one that it stands on. Speeds, progress
    and steps of a walk are those relative to the belts, in their mean where they differ.
    """

    speed: Annotated[Number, "m/s"] = 0.0  # of both belts, backwards
    left: Annotated[Number, "m/s"] = 0.0  # what the left one is faster by
    right: Annotated[Number, "m/s"] = 0.0  # and the right one
    sideways: Annotated[Number, "m/s"] = 0.0  # of both, to the left
    split: Annotated[Number, "m"] = 0.0  # x of the line between them
    profile: Annotated[list[tuple[float, float]], "s and 1"] = []  # times, and what all speeds are multiplied by then
    start: Annotated[Number, "s"] = 0.0  # when the profile begins
