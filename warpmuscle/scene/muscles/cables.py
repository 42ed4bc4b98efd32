"""What pulls along a path and is no muscle: actuators and ligaments of OpenSim, in the place of a muscle's curves."""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.part import Part


class PathActuator(Part, tag_field="type", tag="path_actuator"):
    """A cable whose tension is `f_max` times the muscle's excitation, at once: OpenSim's PathActuator.

    Its `l_opt` and `l_slack` only scale what controllers feel of it.
    """


class Ligament(Part, tag_field="type", tag="ligament"):
    """A ligament, whose tension is `f_max` times a function of its length over `l_slack`: OpenSim's Ligament.

    The function goes through knots (x, y), as that of a `Displacement` does. A ligament that is not longer than
    `l_slack` pulls with nothing. With a `dissipation`, as OpenSim's PathSpring has one, the tension is multiplied by
    1 + dissipation times the speed of lengthening.
    """

    x: Annotated[list[float], "1"]
    y: Annotated[list[float], "1"]
    ends: Literal["simm", "natural", "linear"] = "simm"
    dissipation: Annotated[float, "s/m"] = 0.0


CABLES = PathActuator | Ligament
