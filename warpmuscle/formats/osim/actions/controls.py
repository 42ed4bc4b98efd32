"""Controls over time that a model's controllers prescribe."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.functions import Function, read_function
from warpmuscle.formats.osim.properties import held, last_name
from warpmuscle.scene import Excitation

PRESCRIBED = "PrescribedController"
KNOTS = 201  # of a function of time that is one polynomial
SHORTEST, LONGEST = 1.0e-4, 5.0e-3  # s, between two knots of one of several pieces ...
PIECES = 8  # ... as many as lie within each, if that is long enough
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


def moments(function: Function, duration: float) -> Floats:
    """Times (n,) from 0 to a duration at which a function of time is taken, close together where it has pieces.

    With 5 ms between them, a spline of fifth degree through the values of one of third degree has its speeds within
    a hundredth of the greatest, also where the third derivative jumps.
    """
    own = np.array([t for t in function.x if 0.0 < t < duration])
    if function.constant or not own.size:
        return np.linspace(0.0, duration, KNOTS)
    ends = np.unique([0.0, *own, duration])
    counts = np.ceil(np.diff(ends) / LONGEST).clip(np.minimum(PIECES, np.diff(ends) // SHORTEST + 1)).astype(int)
    inner = [low + (high - low) * np.arange(n) / n for low, high, n in zip(ends[:-1], ends[1:], counts, strict=True)]
    return np.concatenate([*inner, [duration]])


def excitation_of(function: Function, duration: float) -> tuple[Excitation, bool]:
    """A muscle's excitation over time, and whether the control had to be cut to be from 0 to 1."""
    times = np.zeros(1) if function.constant else moments(function, duration)
    values = function.values(times)
    cut = np.clip(values, 0.0, 1.0)
    return Excitation([*map(float, times)], [*map(float, cut)]), bool(np.any(np.abs(cut - values) > ROUNDING))
