"""Forces that are functions or expressions, springs between points, and actuators, as records."""

from __future__ import annotations

from collections.abc import Callable

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.forces import ABOUT_DRAWING
from warpmuscle.formats.osim.frames import Frames
from warpmuscle.formats.osim.functions import ZERO, Function, owned_function, read_function
from warpmuscle.formats.osim.properties import Properties, held, last_name
from warpmuscle.formats.osim.records import OsimForce

Made = tuple[dict[str, tuple[float, ...]], dict[str, str], tuple[str, ...], dict[str, tuple[Function, ...]]]
BUSHING_TAGS = (
    *(f"m_{axis}_theta_{axis}_function" for axis in "xyz"), *(f"f_{axis}_delta_{axis}_function" for axis in "xyz"),
)  # fmt: skip
SETS = ("forceFunctions", "torqueFunctions", "pointFunctions")
CONTROL = "control"  # the function of an actuator that a controller prescribes
LAGGING = "ActivationCoordinateActuator"  # whose activation follows its control, with OpenSim's defaults of ...
LAGS = {"activation_time_constant": 0.01, "default_activation": 0.5}
UNBOUND = ("min_control", "max_control", "activation_time_constant", "default_activation")


def read_action(element: Element, frames: Frames, own: Properties, control: Function | None) -> OsimForce:
    """The force of an element of a class in `READERS`.

    Args:
        control: what a controller prescribes for it, over time; 0 as in OpenSim where none does.

    Raises:
        SceneError: it names no frame or coordinate, or a function of a class that is not known.
    """
    for tag in ABOUT_DRAWING:
        element.child(tag)
    numbers, words, ends, functions = READERS[element.tag](element, frames, own)
    if element.tag.endswith("Actuator"):
        element.child(*UNBOUND)
        functions[CONTROL] = (control or ZERO,)
    return OsimForce(element.tag, element.name, element.line, numbers, words, ends, functions)


def _frame(element: Element, frames: Frames, own: Properties, *names: str) -> str:
    """The frame that a socket or a property with one of these names says."""
    path = f"/forceset/{element.name}"
    for name in names:
        given = element.child(f"socket_{name}") or own.find(element, name)
        if given is not None and given.word():
            return frames.meant(given, path)
    element.fail(f"names no <{names[0]}>")


def _ends(element: Element, frames: Frames, own: Properties, *names: str) -> tuple[str, ...]:
    return tuple(_frame(element, frames, own, name) for name in names)


def _coordinate(element: Element, frames: Frames, own: Properties) -> Made:
    socket = element.child("socket_coordinate")
    name = last_name(own.word(element, "coordinate")) or (last_name(socket.word()) if socket is not None else "")
    numbers: dict[str, tuple[float, ...]] = {"optimal_force": (own.number(element, "optimal_force", 1.0),)}
    if element.tag == LAGGING:
        numbers |= {tag: (own.number(element, tag, usual),) for tag, usual in LAGS.items()}
    return numbers, {"coordinate": name, "expression": own.word(element, "expression", "0")}, (), {}


def _points(element: Element, frames: Frames, own: Properties) -> Made:
    letters = ("A", "B") if element.tag == "PointToPointActuator" else ("1", "2")
    ends = _ends(element, frames, own, *(f"body{letter}" for letter in letters))
    numbers: dict[str, tuple[float, ...]] = {
        f"point{k}": own.vector(element, f"point{letter}") for k, letter in enumerate(letters, 1)
    }
    usual = {"stiffness": 1.0, "rest_length": 0.0, "optimal_force": 1.0}
    numbers |= {tag: (own.number(element, tag, value),) for tag, value in usual.items()}
    if own.truth(element, "points_are_global", False):
        element.fail("its points are of the ground, which are not known here")
    return numbers, {"expression": own.word(element, "expression", "0")}, ends, {}


def _bushing(element: Element, frames: Frames, own: Properties) -> Made:
    ends = _ends(element, frames, own, "frame1", "frame2")
    numbers: dict[str, tuple[float, ...]] = {
        tag: own.vector(element, tag) for tag in ("rotational_damping", "translational_damping")
    }
    return numbers, {}, ends, {"functions": tuple(_function(element, tag) for tag in BUSHING_TAGS)}


def _function(element: Element, name: str) -> Function:
    """The function of a property, within an element of its name or itself of that name; 0 where there is none."""
    holder = held(element, name)
    if holder is None:
        return ZERO
    return (owned_function(holder) or ZERO) if holder.tag == name else read_function(holder)


def _prescribed(element: Element, frames: Frames, own: Properties) -> Made:
    functions: dict[str, tuple[Function, ...]] = {}
    for tag in SETS:
        holder = held(element, tag)
        members = holder.objects() if holder is not None else []
        if len(members) not in (0, 3):
            element.fail(f"has {number_of(len(members), 'function')} in <{tag}>; three are needed, or none")
        functions[tag] = tuple(read_function(one) for one in members) or (ZERO,) * 3
    numbers: dict[str, tuple[float, ...]] = {
        "force_in_body": (0.0 if own.truth(element, "forceIsGlobal", True) else 1.0,),
        "point_in_world": (1.0 if own.truth(element, "pointIsGlobal", False) else 0.0,),
        "scale": (1.0,),
    }
    return numbers, {}, (_frame(element, frames, own, "frame", "body"),), functions


def _point_actuator(element: Element, frames: Frames, own: Properties) -> Made:
    numbers: dict[str, tuple[float, ...]] = {
        "force_in_body": (0.0 if own.truth(element, "force_is_global", False) else 1.0,),
        "point_in_world": (1.0 if own.truth(element, "point_is_global", False) else 0.0,),
        "scale": (own.number(element, "optimal_force", 1.0),),
        "direction": own.vector(element, "direction", (1.0, 0.0, 0.0)),
        "point": own.vector(element, "point"),
    }
    return numbers, {}, (_frame(element, frames, own, "body"),), {}


def _torque(element: Element, frames: Frames, own: Properties) -> Made:
    numbers: dict[str, tuple[float, ...]] = {
        "in_body": (0.0 if own.truth(element, "torque_is_global", True) else 1.0,),
        "optimal_force": (own.number(element, "optimal_force", 1.0),),
        "axis": own.vector(element, "axis", (0.0, 0.0, 1.0)),
    }
    return numbers, {}, _ends(element, frames, own, "bodyA", "bodyB"), {}


READERS: dict[str, Callable[[Element, Frames, Properties], Made]] = {
    "ExpressionBasedCoordinateForce": _coordinate,
    LAGGING: _coordinate,
    "ExpressionBasedPointToPointForce": _points,
    "PointToPointSpring": _points,
    "PointToPointActuator": _points,
    "FunctionBasedBushingForce": _bushing,
    "PrescribedForce": _prescribed,
    "PointActuator": _point_actuator,
    "TorqueActuator": _torque,
}


def taken(element: Element, frames: Frames, own: Properties, control: Function | None) -> OsimForce | str:
    """A force, or why it cannot be represented."""
    try:
        return read_action(element, frames, own, control)
    except SceneError as error:
        return f"{error.message}; it is left out, and pulls on nothing"
