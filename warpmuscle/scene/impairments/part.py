"""What a scene says of impaired muscles."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.number import Number
from warpmuscle.scene.part import ABOVE_0, Part


class Impairment(Part):
    """Weakness, contracture, age or a nerve of other muscles: factors of their numbers of the same names.

    Several impairments of a muscle multiply. A factor may be free, follow a command, and be swept over. What the
    muscles are without their impairments stays in the character, and so do the numbers that follow them (`same_as`).
    """

    muscles: list[str]  # names and patterns of names, such as "?SOL" for those of both legs
    f_max: Annotated[Number, "1", ABOVE_0] = 1.0  # weakness
    l_opt: Annotated[Number, "1", ABOVE_0] = 1.0  # contracture of fibres
    l_slack: Annotated[Number, "1", ABOVE_0] = 1.0  # contracture, or surgical lengthening, of the tendon
    v_max: Annotated[Number, "1", ABOVE_0] = 1.0  # and those below: the muscle's own, or that of all muscles
    rise_time: Annotated[Number, "1", ABOVE_0] = 1.0
    fall_time: Annotated[Number, "1", ABOVE_0] = 1.0
    delay: Annotated[Number, "1", ABOVE_0] = 1.0  # slower nerves
    tendon_strain: Annotated[Number, "1", ABOVE_0] = 1.0  # below 1: a stiffer tendon; of curves that have one
    passive_strain: Annotated[Number, "1", ABOVE_0] = 1.0  # below 1: stiffer fibres


FACTORS = tuple(name for name in Impairment.__struct_fields__ if name != "muscles")
