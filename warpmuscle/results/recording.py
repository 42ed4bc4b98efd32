"""One simulated instance over time, as it is stored, measured and drawn.

`QUANTITIES` states once what each array holds, its axes and its unit; files and figures take their labels from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.arguments import as_kind, as_number, in_words
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError


class Quantity(NamedTuple):
    """What one array of a recording holds.

    Attributes:
        units: unit symbol, "1" for a number without one.
        axes: one name per axis; `frame`, `joint`, `body` and `muscle` are counted by the recording, the words of any
            other name are the components along that axis.
        description: one line.
    """

    units: str
    axes: tuple[str, ...]
    description: str


_VECTOR = ("frame", "x y z")
_JOINT_VECTOR = ("frame", "joint", "x y z")
_MUSCLE = ("frame", "muscle")
_JOINT_QUATERNION = ("frame", "joint", "x y z w")

QUANTITIES: dict[str, Quantity] = {
    "time": Quantity("s", ("frame",), "simulated time"),
    "phase": Quantity("1", ("frame",), "phase of the controller's state, 0 to 1"),
    "stance": Quantity("1", ("frame",), "stance foot: 0 left, 1 right"),
    "state": Quantity("1", ("frame",), "index of the controller's state"),
    "root_position": Quantity("m", _VECTOR, "centre of mass of the root body, world"),
    "root_orientation": Quantity("1", ("frame", "x y z w"), "quaternion, root body to world"),
    "root_velocity": Quantity("m/s", _VECTOR, "velocity of the root's centre of mass, world"),
    "root_angular_velocity": Quantity("rad/s", _VECTOR, "angular velocity of the root body, world"),
    "joint_orientation": Quantity("1", _JOINT_QUATERNION, "quaternion, child body to parent body"),
    "joint_angular_velocity": Quantity("rad/s", _JOINT_VECTOR, "of the child relative to the parent, parent's frame"),
    "joint_torque": Quantity("N m", _JOINT_VECTOR, "torque on the parent, its negative acts on the child, world"),
    "joint_torque_desired": Quantity("N m", _JOINT_VECTOR, "torque that the controller wanted, as joint_torque"),
    "joint_target": Quantity(
        "1", _JOINT_QUATERNION, "quaternion, target orientation of the controller, or as recorded"
    ),
    "com": Quantity("m", _VECTOR, "centre of mass of the whole body, world"),
    "com_velocity": Quantity("m/s", _VECTOR, "velocity of the centre of mass of the whole body, world"),
    "foot_force_left": Quantity("N", _VECTOR, "ground force on the left foot, of the step that ended at this time"),
    "foot_force_right": Quantity("N", _VECTOR, "ground force on the right foot, of the step that ended at this time"),
    "body_position": Quantity("m", ("frame", "body", "x y z"), "centre of mass of each body, world"),
    "body_orientation": Quantity("1", ("frame", "body", "x y z w"), "quaternion, body to world"),
    "muscle_path_length": Quantity("m", _MUSCLE, "length of the muscle with its tendon"),
    "muscle_fibre_length": Quantity("m", _MUSCLE, "length of the muscle fibre"),
    "muscle_fibre_velocity": Quantity("m/s", _MUSCLE, "lengthening speed of the muscle fibre"),
    "muscle_desired_force": Quantity("N", _MUSCLE, "force that the controller or the muscle's own excitation asks for"),
    "muscle_excitation": Quantity("1", _MUSCLE, "excitation that reaches the muscle, after its delay"),
    "muscle_activation": Quantity("1", _MUSCLE, "activation"),
    "muscle_force": Quantity("N", _MUSCLE, "tension of the muscle"),
}
MUSCLE_QUANTITIES = tuple(name for name in QUANTITIES if name.startswith("muscle_"))
INTEGER_QUANTITIES = ("stance", "state")


@dataclass(frozen=True, repr=False)
class Recording:
    """One instance over F frames, J joints, B bodies and M muscles; see `QUANTITIES` for units and meaning.

    Joints are in breadth-first order from the root; bodies are the root followed by the children of those joints.
    Raises ArgumentError, a ValueError, if a shape does not fit.
    """

    joint_names: tuple[str, ...]
    body_names: tuple[str, ...]
    muscle_names: tuple[str, ...]
    time: Floats  # (F,)
    phase: Floats  # (F,)
    stance: Integers  # (F,)
    state: Integers  # (F,)
    root_position: Floats  # (F, 3)
    root_orientation: Floats  # (F, 4)
    root_velocity: Floats  # (F, 3)
    root_angular_velocity: Floats  # (F, 3)
    joint_orientation: Floats  # (F, J, 4)
    joint_angular_velocity: Floats  # (F, J, 3)
    joint_torque: Floats  # (F, J, 3)
    joint_torque_desired: Floats  # (F, J, 3)
    joint_target: Floats  # (F, J, 4)
    com: Floats  # (F, 3)
    com_velocity: Floats  # (F, 3)
    foot_force_left: Floats  # (F, 3)
    foot_force_right: Floats  # (F, 3)
    body_position: Floats  # (F, B, 3)
    body_orientation: Floats  # (F, B, 4)
    muscle_path_length: Floats  # (F, M)
    muscle_fibre_length: Floats  # (F, M)
    muscle_fibre_velocity: Floats  # (F, M)
    muscle_desired_force: Floats  # (F, M)
    muscle_excitation: Floats  # (F, M)
    muscle_activation: Floats  # (F, M)
    muscle_force: Floats  # (F, M)

    def __post_init__(self) -> None:
        names = {"joint": self.joint_names, "body": self.body_names, "muscle": self.muscle_names}
        counts = {"frame": len(self.time)} | {axis: len(members) for axis, members in names.items()}
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
    ) -> Recording:
        """A recording from arrays by name of their quantity; raises ArgumentError if one is missing.

        Without muscles their arrays may be missing, and so may the desired torque, which then is the torque.
        """
        present: dict[str, Any] = {"joint_torque_desired": arrays.get("joint_torque"), **arrays}
        if not muscle_names:
            nothing = np.zeros((len(arrays.get("time", ())), 0))
            present = {**dict.fromkeys(MUSCLE_QUANTITIES, nothing), **present}
        if missing := [name for name in QUANTITIES if present.get(name) is None]:
            raise ArgumentError(f"arrays of a recording lack {', '.join(missing)}")
        return cls(joint_names, body_names, muscle_names, **{name: present[name] for name in QUANTITIES})

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
        arrays = {name: self[name][chosen] for name in QUANTITIES}
        return Recording.of(arrays, self.joint_names, self.body_names, self.muscle_names)

    def position_of(self, body: str) -> Floats:
        """Centre of mass (F, 3) of a body by name, m; raises ArgumentError for an unknown name."""
        if not isinstance(body, str) or body not in self.body_names:
            raise ArgumentError(f"no body is called {in_words(body)}; there are {', '.join(self.body_names)}")
        return self.body_position[:, self.body_names.index(body)]


def label(name: str) -> str:
    """Axis label of a quantity, such as `root velocity (m/s)`."""
    unit = QUANTITIES[name].units
    return name.replace("_", " ") + ("" if unit == "1" else f" ({unit})")
