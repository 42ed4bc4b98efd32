"""What pulls along a path and is no muscle: actuators and ligaments of OpenSim, in the place of a muscle's curves."""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.part import ABOVE_0, FROM_0, Part


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
    dissipation: Annotated[float, "s/m", FROM_0] = 0.0


class BlankevoortLigament(Part, tag_field="type", tag="blankevoort"):
    """A ligament with a toe, whose stiffness over strain is `f_max`: OpenSim's Blankevoort1991Ligament.

    Its tension is f_max e^2/(2 e_t) at strains e of `l_slack` up to `transition_strain`, and f_max (e - e_t/2) beyond
    (Blankevoort and Huiskes 1991, eq. 1). While it lengthens, f_max `damping` times the rate of strain comes to it.
    """

    transition_strain: Annotated[float, "1", ABOVE_0] = 0.06
    damping: Annotated[float, "s", FROM_0] = 0.0


LIGAMENTS = Ligament | BlankevoortLigament
CABLES = PathActuator | LIGAMENTS


def is_straight(ligament: Ligament) -> bool:
    """Whether its tension is a spring's without damping: 0 at its length at rest, and f_max at twice that."""
    line = ligament.ends == "linear" and (ligament.x, ligament.y) == ([1.0, 2.0], [0.0, 1.0])
    return line and ligament.dissipation == 0.0
