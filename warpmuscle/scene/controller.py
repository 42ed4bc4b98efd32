"""The controller of a scene, of whichever type, and what it may be commanded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import Part
from warpmuscle.scene.simbicon.controller import Simbicon

SIMBICON = "simbicon"
EVERY_OTHER = "others"  # name of all that have no values of their own


def declared_value(table: Mapping[str, Mapping[str, Number]], name: str, parameter: str) -> Number | None:
    """The value that a joint, body or muscle has of a parameter, or that every other one has; None if there is none."""
    return table.get(name, {}).get(parameter, table.get(EVERY_OTHER, {}).get(parameter))


class Controller(Simbicon):
    """What controls joints and muscles.

    `type`: `simbicon`, which takes the keys of a SIMBICON controller; or another one of `control/controllers.py`, or
    `module:name` of a `control.CustomController` of one's own. These take parameters, numbers that may be free:
    `parameters` of the whole, and of each joint, body or muscle what stands under its name, or else under `others`.
    """

    type: str = SIMBICON  # simbicon, joint_pd, quadratic_program, walking, or `module:name`
    parameters: Annotated[dict[str, Number], "1"] = {}  # of the whole, by name; not of simbicon
    by_joint: Annotated[dict[str, dict[str, Number]], "1"] = {}  # of each joint that moves, or of `others`
    by_body: Annotated[dict[str, dict[str, Number]], "1"] = {}  # of each body, or of `others`
    by_muscle: Annotated[dict[str, dict[str, Number]], "1"] = {}  # of each muscle, or of `others`


class Command(Part):
    """A number that a user gives at run time. Numbers of the scene with `per` follow it.

    Its unit is its own: that of `min`, `max`, `reference` and `value`.
    """

    reference: float  # where numbers that follow it have their own value
    min: float
    max: float
    value: float | None = None  # what is asked for; by default the reference
    over: Annotated[list[tuple[float, float]], "1"] = []  # time, s, and what is asked for then, straight between
    unit: str = ""  # such as "m/s" or "deg"
    description: str = ""

    @property
    def asked(self) -> float:
        """The value, or the reference; of one that changes over time the value at the start."""
        if self.over:
            return self.over[0][1]
        return self.reference if self.value is None else self.value

    def at(self, time: float) -> float:
        """What is asked for at a time, s: straight between the knots of `over`, and constant beyond them."""
        if not self.over:
            return self.asked
        return float(np.interp(time, [knot for knot, _ in self.over], [value for _, value in self.over]))
