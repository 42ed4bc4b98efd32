"""One simulated instance over time, as it is stored, measured and drawn.

`Recording` declares once what each array holds, its axes, its unit and how it is made from what a device wrote; files
and figures take their labels from it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.arguments import as_kind, as_number, as_texts, in_words
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.labelled import Labelled, to_dataframe, to_xarray
from warpmuscle.core.pose import conjugate, multiply, rotate
from warpmuscle.kernels.recorded import (
    ACTIVATION,
    DESIRED_FORCE,
    EXCITATION,
    FIBRE_LENGTH,
    FIBRE_VELOCITY,
    FORCE,
    PATH_LENGTH,
)

if TYPE_CHECKING:
    import pandas
    import xarray


START, OVER, END = "start of the step", "over the step", "end of the step"  # of that which starts at a frame's time
BEFORE = "over the step before"
BESIDE = "by the activation recorded beside it"
LENGTH = f"{START}; with a compliant tendon: {BESIDE}"
SPEED = f"middle of the step before, by moment arms of the start; with a compliant tendon: {BEFORE}, {BESIDE}"
END_UNLESS = f"{END}; of neural activation: {START}"


@dataclass(frozen=True)
class RawFrames:
    """What a device wrote of one instance: F frames of `kernels.structs.Record`, and what reading them takes."""

    time: Floats  # (F,) s
    arrays: Mapping[str, Floats]  # by field of the record
    parents: list[int]  # (J,) body that each joint's child hangs on
    root_velocity: Floats  # (F, 3) m/s
    centers: Floats  # (B, 3) m, centres of mass from the joints, body axes

    def __getitem__(self, name: str) -> Floats:
        return self.arrays[name]

    @property
    def unturned(self) -> Floats:
        """Orientation of the world in each joint's parent, (F, J, 4)."""
        return conjugate(self["orientation"][:, self.parents])


class Quantity(NamedTuple):
    """What one array of a recording holds.

    Attributes:
        units: unit symbol, "1" for a number without one.
        axes: one name per axis; `frame` and those of `NAMED` are counted by the recording, the words of any other name
            are the components along that axis.
        description: one line.
        of: makes it from what a device wrote.
        at: when, if not at the frame's time: a frame is written by the step that starts then.
    """

    units: str
    axes: tuple[str, ...]
    description: str
    of: Callable[[RawFrames], Floats]
    at: str = START


def _quantity(
    units: str, axes: tuple[str, ...], description: str, of: Callable[[RawFrames], Floats], at: str = START
) -> Any:
    """A field that holds a quantity."""
    return field(metadata={"quantity": Quantity(units, axes, description, of, at)})


def _of_muscles(units: str, place: int, description: str, at: str = START) -> Any:
    """A field that holds what the device writes of every muscle in a place of its own."""
    return _quantity(units, ("frame", "muscle"), description, lambda raw: raw["muscle"][:, place], at)


_FRAME = ("frame",)
_VECTOR = ("frame", "x y z")
_JOINT_VECTOR = ("frame", "joint", "x y z")
_JOINT_QUATERNION = ("frame", "joint", "x y z w")


@dataclass(frozen=True, repr=False)
class Recording:
    """One instance over F frames, J joints, B bodies and M muscles; `QUANTITIES` lists its arrays.

    Joints are in breadth-first order from the root; bodies are the root followed by the children of those joints.
    Coordinates and speeds have the names of `topology.coordinate_names`, angles those of `degrees_of_freedom`; what was
    recorded before they were has none.
    Raises ArgumentError, a ValueError, if a shape does not fit.
    """

    joint_names: tuple[str, ...]
    body_names: tuple[str, ...]
    muscle_names: tuple[str, ...]
    time: Floats = _quantity("s", _FRAME, "simulated time", lambda raw: raw.time)
    phase: Floats = _quantity("1", _FRAME, "phase of the controller's state, 0 to 1 or more", lambda raw: raw["phase"])
    stance: Integers = _quantity("1", _FRAME, "stance foot: 0 left, 1 right", lambda raw: raw["stance"])
    state: Integers = _quantity("1", _FRAME, "index of the controller's state", lambda raw: raw["machine_state"])
    root_position: Floats = _quantity(
        "m", _VECTOR, "centre of mass of the root body, world", lambda raw: raw["position"][:, 0]
    )
    root_orientation: Floats = _quantity(
        "1", ("frame", "x y z w"), "quaternion, root body to world", lambda raw: raw["orientation"][:, 0]
    )
    root_velocity: Floats = _quantity(
        "m/s", _VECTOR, "velocity of the root's centre of mass, world", lambda raw: raw.root_velocity
    )
    root_angular_velocity: Floats = _quantity(
        "rad/s", _VECTOR, "angular velocity of the root body, world", lambda raw: raw["angular_velocity"][:, 0]
    )
    joint_orientation: Floats = _quantity(
        "1", _JOINT_QUATERNION, "quaternion, child body to parent body",
        lambda raw: multiply(raw.unturned, raw["orientation"][:, 1:]),
    )  # fmt: skip
    joint_angular_velocity: Floats = _quantity(
        "rad/s", _JOINT_VECTOR, "of the child relative to the parent, parent's frame",
        lambda raw: rotate(raw.unturned, raw["angular_velocity"][:, 1:] - raw["angular_velocity"][:, raw.parents]),
    )  # fmt: skip
    joint_torque: Floats = _quantity(
        "N m", _JOINT_VECTOR, "torque on the parent over the step, without stops, its negative on the child, world",
        lambda raw: raw["torque"][:, 1:], OVER,
    )  # fmt: skip
    joint_torque_desired: Floats = _quantity(
        "N m", _JOINT_VECTOR, "torque that the controller wanted at the step's start, as joint_torque",
        lambda raw: raw["desired_torque"][:, 1:],
    )  # fmt: skip
    joint_target: Floats = _quantity(
        "1", _JOINT_QUATERNION, "quaternion, target orientation of the controller, or as recorded",
        lambda raw: raw["target"][:, 1:],
    )  # fmt: skip
    com: Floats = _quantity("m", _VECTOR, "centre of mass of the whole body, world", lambda raw: raw["com"][:, 0])
    com_velocity: Floats = _quantity(
        "m/s", _VECTOR, "velocity of the centre of mass of the whole body, world", lambda raw: raw["com"][:, 1]
    )
    foot_force_left: Floats = _quantity(
        "N", _VECTOR, "ground force on the left foot, of the step that ended at this time",
        lambda raw: raw["foot_force"][:, 0], BEFORE,
    )  # fmt: skip
    foot_force_right: Floats = _quantity(
        "N", _VECTOR, "ground force on the right foot, of the step that ended at this time",
        lambda raw: raw["foot_force"][:, 1], BEFORE,
    )  # fmt: skip
    body_position: Floats = _quantity(
        "m", ("frame", "body", "x y z"), "centre of mass of each body, world",
        lambda raw: raw["position"] + rotate(raw["orientation"], raw.centers),
    )  # fmt: skip
    body_orientation: Floats = _quantity(
        "1", ("frame", "body", "x y z w"), "quaternion, body to world", lambda raw: raw["orientation"]
    )
    muscle_path_length: Floats = _of_muscles("m", PATH_LENGTH, "length of the muscle with its tendon")
    muscle_fibre_length: Floats = _of_muscles("m", FIBRE_LENGTH, "length of the muscle fibre", LENGTH)
    muscle_fibre_velocity: Floats = _of_muscles("m/s", FIBRE_VELOCITY, "lengthening speed of the muscle fibre", SPEED)
    muscle_desired_force: Floats = _of_muscles(
        "N", DESIRED_FORCE, "force that the controller or the muscle's own excitation asks for"
    )
    muscle_excitation: Floats = _of_muscles(
        "1", EXCITATION, "excitation that reaches the muscle, after its delay", OVER
    )
    muscle_activation: Floats = _of_muscles(
        "1", ACTIVATION, "activation with which the muscle pulls over the step that starts at this time", END_UNLESS
    )
    muscle_force: Floats = _of_muscles(
        "N", FORCE, "tension of the muscle, which accelerates the joints at this time", f"{START}, {BESIDE}"
    )
    coordinate: Floats = _quantity(
        "rad or m", ("frame", "coordinate"), "coordinates of root and joints, quaternions of balls among them",
        lambda raw: raw["coordinates"],
    )  # fmt: skip
    speed: Floats = _quantity(
        "rad/s or m/s", ("frame", "speed"), "rates of the coordinates; of a root along and about the world, of a ball "
        "about its child's axes", lambda raw: raw["speeds"],
    )  # fmt: skip
    joint_angle: Floats = _quantity(
        "rad", ("frame", "joint_angle"), "angles of root and joints by degree of freedom, as an exported .mot has them",
        lambda raw: np.zeros((len(raw.time), 0)),  # see `degrees_of_freedom.with_joint_angles`
    )  # fmt: skip
    coordinate_names: tuple[str, ...] = ()
    speed_names: tuple[str, ...] = ()
    joint_angle_names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        counts = {axis: len(getattr(self, name)) for axis, name in NAMED.items()} | {"frame": len(self.time)}
        for name, quantity in QUANTITIES.items():
            array = as_kind(np.ndarray, self[name], name)
            expected = tuple(counts.get(axis, len(axis.split())) for axis in quantity.axes)
            if array.shape != expected:
                raise ArgumentError(f"{name} has shape {array.shape}, not {expected} ({', '.join(quantity.axes)})")

    def __repr__(self) -> str:
        span = f", {self.time[0]:.4g} to {self.time[-1]:.4g} s" if self.frames else ""
        counts = {"bodies": self.body_names, "joints": self.joint_names, "muscles": self.muscle_names}
        parts = "".join(f", {len(names)} {what}" for what, names in counts.items())
        return f"Recording({self.frames} frames{span}{parts})"

    def __getitem__(self, name: str) -> NDArray[Any]:
        """The array of a quantity; raises ArgumentError for an unknown name."""
        if not isinstance(name, str) or name not in QUANTITIES:
            raise ArgumentError(f"no quantity is called {in_words(name)}; there are {', '.join(QUANTITIES)}")
        array: NDArray[Any] = getattr(self, name)
        return array

    @classmethod
    def of(
        cls,
        arrays: Mapping[str, NDArray[Any]],
        joint_names: tuple[str, ...],
        body_names: tuple[str, ...],
        muscle_names: tuple[str, ...] = (),
        coordinate_names: tuple[str, ...] = (),
        speed_names: tuple[str, ...] = (),
        joint_angle_names: tuple[str, ...] = (),
    ) -> Self:
        """A recording from arrays by name of their quantity; raises ArgumentError if one is missing.

        What has no names may be missing, and so may the desired torque, which then is the torque.
        """
        present: dict[str, Any] = {"joint_torque_desired": arrays.get("joint_torque"), **arrays}
        nothing = np.zeros((len(arrays.get("time", ())), 0))
        optional = {"coordinate": coordinate_names, "speed": speed_names, "joint_angle": joint_angle_names}
        for axis, names in {"muscle": muscle_names, **optional}.items():
            if not names:
                present = {**dict.fromkeys(quantities_of(axis), nothing), **present}
        if missing := [name for name in QUANTITIES if present.get(name) is None]:
            raise ArgumentError(f"arrays of a recording lack {', '.join(missing)}")
        given = {name: present[name] for name in QUANTITIES}
        named: dict[str, Any] = {NAMED[axis]: names for axis, names in optional.items()}
        return cls(joint_names, body_names, muscle_names, **given, **named)

    @classmethod
    def from_frames(
        cls,
        raw: RawFrames,
        joint_names: tuple[str, ...],
        body_names: tuple[str, ...],
        muscle_names: tuple[str, ...],
        coordinate_names: tuple[str, ...],
        speed_names: tuple[str, ...],
    ) -> Self:
        """A recording of what a device wrote."""
        arrays: dict[str, Any] = {name: quantity.of(raw) for name, quantity in QUANTITIES.items()}
        arrays |= {name: arrays[name].astype(np.int32) for name in INTEGER_QUANTITIES}
        return cls(
            joint_names, body_names, muscle_names, **arrays, coordinate_names=coordinate_names, speed_names=speed_names
        )

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.time)

    @property
    def has_targets(self) -> bool:
        """Whether joints were to move anywhere but to their reference pose."""
        return bool(np.any(self.joint_target[..., :3]))

    def window(self, start: float, end: float = np.inf) -> Recording:
        """The frames with start <= time <= end, s; these may be infinite. Raises ArgumentError."""
        start, end = as_number(start, "start", infinite=True), as_number(end, "end", infinite=True)
        chosen = (self.time >= start) & (self.time <= end)
        return self.at(chosen)

    def at(self, frames: Any) -> Self:
        """Some of its frames, by a slice, numbers or a mask."""
        return replace(self, **{name: self[name][frames] for name in QUANTITIES})

    def to_xarray(self) -> xarray.Dataset:
        """All quantities as an `xarray.Dataset`, with units, over `time`, `muscle_names`, `joint_names` and so on.

        It is what `xarray.open_dataset` makes of the motion in a result file. Raises Error without xarray.
        """
        time, arrays = self._labelled(list(QUANTITIES))
        return to_xarray(time, arrays, {dimension(axis): words for axis, words in self._words().items()})

    def to_dataframe(self, quantities: Sequence[str] | None = None) -> pandas.DataFrame:
        """A `pandas.DataFrame` with a row a frame, by time in s, and columns such as `com.x` and `muscle_force.rSOL`.

        Args:
            quantities: names of those that are wanted; all by default.

        Raises:
            ArgumentError: an unknown name. Error: pandas is not installed.
        """
        chosen = list(QUANTITIES) if quantities is None else as_texts(quantities, "quantities")
        time, arrays = self._labelled(chosen)
        return to_dataframe(time, arrays, {dimension(axis): words for axis, words in self._words().items()})

    def _words(self) -> dict[str, Sequence[str]]:
        """What stands along the axes, by axis; not along those of which there is nothing."""
        axes = dict.fromkeys(axis for quantity in QUANTITIES.values() for axis in quantity.axes[1:])
        words = {axis: getattr(self, NAMED[axis]) if axis in NAMED else axis.split() for axis in axes}
        return {axis: along for axis, along in words.items() if along}

    def _labelled(self, quantities: Sequence[str]) -> tuple[Labelled, list[Labelled]]:
        """The time, and the arrays of quantities with their names of axes and units."""
        words = self._words()
        found = []
        for name in ("time", *(name for name in quantities if name != "time")):
            values, quantity = self[name], QUANTITIES[name]
            if all(axis in words for axis in quantity.axes[1:]):
                attributes = {"units": quantity.units, "description": quantity.description}
                found.append(Labelled(name, tuple(map(dimension, quantity.axes)), values, attributes))
        return found[0], found[1:]

    def position_of(self, body: str) -> Floats:
        """Centre of mass (F, 3) of a body by name, m; raises ArgumentError for an unknown name."""
        if not isinstance(body, str) or body not in self.body_names:
            raise ArgumentError(f"no body is called {in_words(body)}; there are {', '.join(self.body_names)}")
        return self.body_position[:, self.body_names.index(body)]


COUNTED = ("joint", "body", "muscle", "coordinate", "speed", "joint_angle")  # axes
NAMED = {axis: f"{axis}_names" for axis in COUNTED}
_DECLARED = [one for one in fields(Recording) if one.metadata]
QUANTITIES: dict[str, Quantity] = {one.name: one.metadata["quantity"] for one in _DECLARED}


def quantities_of(axis: str) -> tuple[str, ...]:
    """Names of the quantities that are along an axis."""
    return tuple(name for name, quantity in QUANTITIES.items() if axis in quantity.axes)


MUSCLE_QUANTITIES = quantities_of("muscle")
INTEGER_QUANTITIES = tuple(one.name for one in _DECLARED if one.type == "Integers")


def dimension(axis: str) -> str:
    """Name of what stands along an axis, in files and tables: `time`, `muscle_names`, or `xyz`."""
    return NAMED.get(axis, "time" if axis == "frame" else axis.replace(" ", ""))


def label(name: str) -> str:
    """Axis label of a quantity, such as `root velocity (m/s)`."""
    unit = QUANTITIES[name].units
    return name.replace("_", " ") + ("" if unit == "1" else f" ({unit})")
