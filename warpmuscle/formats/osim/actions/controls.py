"""Controls over time that a model's controllers prescribe."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.functions import Function, read_function
from warpmuscle.formats.osim.properties import held, last_name
from warpmuscle.scene import Excitation

PRESCRIBED = "PrescribedController"
KNOTS = 201  # of a control that is no straight line
ROUNDING = 1e-12
LISTS = ("socket_actuators", "actuator_list", "actuators")  # of versions 4.5 on, and before


def read_controls(controllers: Iterable[Element], actuators: list[str]) -> dict[str, Function]:
    """The functions of time of prescribed controllers by actuator; each controller counts as read.

    Args:
        actuators: names of all there are, for a controller of "all".

    Raises:
        SceneError: a function of a class that is not known, or one for no actuator.
    """
    found: dict[str, Function] = {}
    for controller in controllers:
        given = next((child for tag in LISTS if (child := controller.child(tag)) is not None and child.words()), None)
        words = [last_name(word) for word in given.words()] if given is not None else []
        names = actuators if [word.lower() for word in words] == ["all"] else words
        holder = held(controller, "ControlFunctions")
        for index, element in enumerate(holder.objects() if holder is not None else ()):
            name = last_name(element.name)
            if name not in names:
                if index >= len(names):
                    element.fail("is the control of no actuator")
                name = names[index]
            found[name] = read_function(element)
        controller.child("enabled", "interpolation_method", "controls_file")
    return found


def excitation_of(function: Function, duration: float) -> tuple[Excitation, bool]:
    """A muscle's excitation over time, and whether the control had to be cut to be from 0 to 1."""
    grid = [] if function.constant else np.linspace(0.0, duration, KNOTS).tolist()
    times = np.unique([0.0, *grid, *(t for t in function.x if 0.0 <= t <= duration and not function.constant)])
    values = function.values(times)
    cut = np.clip(values, 0.0, 1.0)
    return Excitation([*map(float, times)], [*map(float, cut)]), bool(np.any(np.abs(cut - values) > ROUNDING))
