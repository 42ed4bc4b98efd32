"""Forces of a model that depend on time, as of actuators under controls, which no motion that is followed has."""

from __future__ import annotations

import re
from collections.abc import Mapping

from warpmuscle.scene import Force

_TIME = re.compile(r"\bt\b")


def without_timed(forces: Mapping[str, Force]) -> dict[str, Force]:
    """Forces that do not depend on time.

    Time of a simulation that follows a motion begins anew with every window that is tried. An actuator whose activation
    falls from its default one, as an `ActivationCoordinateActuator`'s, would pull as at first throughout. What
    actuators would have to make is told as the effort beside muscles.
    """
    return {
        name: one for name, one in forces.items() if not any(_TIME.search(text) for text in one.expressions.values())
    }
