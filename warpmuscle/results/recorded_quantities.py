"""The arrays of a recording: what each holds, its axes, its unit, and how it is made of what a device wrote.

They are declared once; files, tables and figures take their labels from here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import Field, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.pose import multiply, rotate
from warpmuscle.kernels.recording.recorded import (
    ACTIVATION,
    DESIRED_FORCE,
    EXCITATION,
    FIBRE_LENGTH,
    FIBRE_VELOCITY,
    FORCE,
    PATH_LENGTH,
)
from warpmuscle.results import simbicon
from warpmuscle.results.quantity import (
    BEFORE,
    BESIDE,
    END_UNLESS,
    LENGTH,
    OVER,
    SPEED,
    START,
    Quantity,
    of_muscles,
    quantity,
)

_FRAME = ("frame",)
_VECTOR = ("frame", "x y z")
_JOINT_VECTOR = ("frame", "joint", "x y z")
_JOINT_QUATERNION = ("frame", "joint", "x y z w")


@dataclass(frozen=True, repr=False)
class RecordedQuantities:
    """What a `Recording` of F frames, J joints, B bodies and M muscles has of arrays and names."""

    joint_names: tuple[str, ...]
    body_names: tuple[str, ...]
    muscle_names: tuple[str, ...]
    time: Floats = quantity("s", _FRAME, "simulated time", lambda raw: raw.time)
    phase: Floats = simbicon.PHASE
    stance: Integers = simbicon.STANCE
    state: Integers = simbicon.STATE
    root_position: Floats = quantity(
        "m", _VECTOR, "centre of mass of the root body, world", lambda raw: raw["position"][:, 0]
    )
    root_orientation: Floats = quantity(
        "1", ("frame", "x y z w"), "quaternion, root body to world", lambda raw: raw["orientation"][:, 0]
    )
    root_velocity: Floats = quantity(
        "m/s", _VECTOR, "velocity of the root's centre of mass, world", lambda raw: raw.root_velocity
    )
    root_angular_velocity: Floats = quantity(
        "rad/s", _VECTOR, "angular velocity of the root body, world", lambda raw: raw["angular_velocity"][:, 0]
    )
    joint_orientation: Floats = quantity(
        "1", _JOINT_QUATERNION, "quaternion, child body to parent body",
        lambda raw: multiply(raw.unturned, raw["orientation"][:, 1:]),
    )  # fmt: skip
    joint_angular_velocity: Floats = quantity(
        "rad/s", _JOINT_VECTOR, "of the child relative to the parent, parent's frame",
        lambda raw: rotate(raw.unturned, raw["angular_velocity"][:, 1:] - raw["angular_velocity"][:, raw.parents]),
    )  # fmt: skip
    joint_torque: Floats = quantity(
        "N m", _JOINT_VECTOR, "torque on the parent over the step, without stops, its negative on the child, world",
        lambda raw: raw["torque"][:, 1:], OVER,
    )  # fmt: skip
    joint_torque_desired: Floats = quantity(
        "N m", _JOINT_VECTOR, "torque that the controller wanted at the step's start, as joint_torque",
        lambda raw: raw["desired_torque"][:, 1:],
    )  # fmt: skip
    joint_target: Floats = quantity(
        "1", _JOINT_QUATERNION, "quaternion, target orientation of the controller, or as recorded",
        lambda raw: raw["target"][:, 1:],
    )  # fmt: skip
    com: Floats = quantity("m", _VECTOR, "centre of mass of the whole body, world", lambda raw: raw["com"][:, 0])
    com_velocity: Floats = quantity(
        "m/s",
        _VECTOR,
        "velocity of the centre of mass of the whole body, world; on a treadmill relative to its belts",
        lambda raw: raw["com"][:, 1],
    )
    foot_force_left: Floats = quantity(
        "N", _VECTOR, "ground force on the left foot, of the step that ended at this time",
        lambda raw: raw["foot_force"][:, 0], BEFORE,
    )  # fmt: skip
    foot_force_right: Floats = quantity(
        "N", _VECTOR, "ground force on the right foot, of the step that ended at this time",
        lambda raw: raw["foot_force"][:, 1], BEFORE,
    )  # fmt: skip
    body_position: Floats = quantity(
        "m", ("frame", "body", "x y z"), "centre of mass of each body, world",
        lambda raw: raw["position"] + rotate(raw["orientation"], raw.centers),
    )  # fmt: skip
    body_orientation: Floats = quantity(
        "1", ("frame", "body", "x y z w"), "quaternion, body to world", lambda raw: raw["orientation"]
    )
    muscle_path_length: Floats = of_muscles("m", PATH_LENGTH, "length of the muscle with its tendon")
    muscle_fibre_length: Floats = of_muscles("m", FIBRE_LENGTH, "length of the muscle fibre", LENGTH)
    muscle_fibre_velocity: Floats = of_muscles("m/s", FIBRE_VELOCITY, "lengthening speed of the muscle fibre", SPEED)
    muscle_desired_force: Floats = of_muscles(
        "N", DESIRED_FORCE, "force that the controller or the muscle's own excitation asks for"
    )
    muscle_excitation: Floats = of_muscles("1", EXCITATION, "excitation that reaches the muscle, after its delay", OVER)
    muscle_activation: Floats = of_muscles(
        "1", ACTIVATION, "activation with which the muscle pulls over the step that starts at this time", END_UNLESS
    )
    muscle_force: Floats = of_muscles(
        "N", FORCE, "tension of the muscle, which accelerates the joints at this time", f"{START}, {BESIDE}"
    )
    coordinate: Floats = quantity(
        "rad or m", ("frame", "coordinate"), "coordinates of root and joints, quaternions of balls among them; "
        "each has its unit in coordinate_units", lambda raw: raw["coordinates"],
    )  # fmt: skip
    speed: Floats = quantity(
        "rad/s or m/s", ("frame", "speed"), "rates of the coordinates; of a root along and about the world, of a ball "
        "about its child's axes; each has its unit in speed_units", lambda raw: raw["speeds"],
    )  # fmt: skip
    joint_angle: Floats = quantity(
        "rad", ("frame", "joint_angle"), "angles of root and joints by degree of freedom, as an exported .mot has them",
        lambda raw: np.zeros((len(raw.time), 0)),  # see `degrees_of_freedom.with_joint_angles`
    )  # fmt: skip
    controller_value: Floats = quantity(
        "own", ("frame", "controller_value"), "what a declared controller lets be recorded of its memory, after the "
        "controller's update at this time; each has its unit in controller_value_units",
        lambda raw: raw.arrays.get("memory", np.zeros((len(raw.time), 0))),
    )  # fmt: skip
    recorded: Floats = quantity(
        "as recorded_units", ("frame", "recorded"), "what the scene's own quantities say, see `Scene.recorded`; "
        "each has its unit in recorded_units", lambda raw: raw["custom"],
    )  # fmt: skip
    coordinate_names: tuple[str, ...] = ()
    speed_names: tuple[str, ...] = ()
    joint_angle_names: tuple[str, ...] = ()
    controller_value_names: tuple[str, ...] = ()
    recorded_names: tuple[str, ...] = ()
    coordinate_units: tuple[str, ...] = ()
    speed_units: tuple[str, ...] = ()
    controller_value_units: tuple[str, ...] = ()
    recorded_units: tuple[str, ...] = ()


COUNTED = ("joint", "body", "muscle", "coordinate", "speed", "joint_angle", "controller_value", "recorded")  # axes
NAMED = {axis: f"{axis}_names" for axis in COUNTED}
UNITS = {  # of axes whose members have units of their own
    axis: f"{axis}_units" for axis in ("coordinate", "speed", "controller_value", "recorded")
}


def declared(kind: type[Any]) -> list[Field[Any]]:
    """Fields of a class that hold quantities; TypeError if an array does not say which, with its name."""
    for one in fields(kind):
        if one.type in ("Floats", "Integers") and "quantity" not in one.metadata:
            raise TypeError(f"{one.name} of {kind.__name__} declares no quantity: give it a `quantity(...)`")
    return [one for one in fields(kind) if one.metadata]


_DECLARED = declared(RecordedQuantities)
QUANTITIES: dict[str, Quantity] = {one.name: one.metadata["quantity"] for one in _DECLARED}


def quantities_of(axis: str) -> tuple[str, ...]:
    """Names of the quantities that are along an axis."""
    return tuple(name for name, quantity in QUANTITIES.items() if axis in quantity.axes)


MUSCLE_QUANTITIES = quantities_of("muscle")
INTEGER_QUANTITIES = tuple(one.name for one in _DECLARED if one.type == "Integers")


def is_missing(array: NDArray[Any], frames: int) -> bool:
    """Whether the array of a quantity was not kept, in a recording of so many frames."""
    return len(array) < frames and 0 not in array.shape[1:]


def attributes_of(name: str) -> dict[str, str]:
    """What tables and files say of a quantity."""
    about = QUANTITIES[name]
    return {"units": about.units, "description": about.description, "at": about.at}


def has_place(name: str, texts: Mapping[str, Sequence[str]]) -> bool:
    """Whether motions with these names along their axes, by name of the field, have any numbers of a quantity."""
    return all(texts[NAMED[axis]] for axis in QUANTITIES[name].axes if axis in NAMED)


def empty(name: str, texts: Mapping[str, Sequence[str]], frames: int) -> NDArray[Any]:
    """The array of a quantity over no frames, or over some where it has no place."""
    sizes = (len(texts[NAMED[axis]] if axis in NAMED else axis.split()) for axis in QUANTITIES[name].axes[1:])
    shape = (frames, *sizes)
    return np.zeros(shape, np.int32 if name in INTEGER_QUANTITIES else np.float64)


def dimension(axis: str) -> str:
    """Name of what stands along an axis, in files and tables: `time`, `muscle_names`, or `xyz`."""
    return NAMED.get(axis, "time" if axis == "frame" else axis.replace(" ", ""))
