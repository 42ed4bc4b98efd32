"""Reads joint motion over the phases of steps from NumPy archives (`.npz`), to be tracked.

A file has K frames, each at a phase of a step:

- `phase` (K,), of the controller's state, 0 to 1, and `stance` (K,), 0 left, 1 right; or, for data given over the gait
  cycle, `cycle` (K,), 0 to 1 from one touch-down of the left foot to the next, the right one's being at 0.5
- `time` (K,), s; may be left out, and then all frames count
- `period`, s, of a cycle; with it the strides before the second landing of the left foot count, too
- an array for each joint, of its name: angles in rad, (K,) of a hinge, (K, 2) of a universal joint about its axes,
  (K, 3) of a ball joint about x, then the new y, then the new z axis; or (K, 4) quaternions of the child in the parent,
  x, y, z, w. What has no joint's name is not read.

Recordings of the original program have other names: `t`, `phi`, `stance`, `joint_names` (J,), and `joint_quat`
(K, J, 4), w first.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.archive import DamagedArchive, arrays_of
from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ResultError
from warpmuscle.scene import Character, Joint
from warpmuscle.scene.joints import joint_type

FRAMES = ("time", "phase", "stance", "cycle", "period")
ORIGINAL = ("t", "phi", "stance", "joint_names", "joint_quat")
LARGEST_PHASE = 2.0  # a foot that comes down late lets the phase run beyond 1
LARGEST_ANGLE = 2.0 * np.pi  # rad
QUATERNION_ERROR = 1e-3
SHORTEST, LONGEST = 0.05, 100.0  # s, of a gait cycle


@dataclass(frozen=True)
class JointMotion:
    """Orientations of J joints in K frames; see `recorded_quantities.QUANTITIES`."""

    joint_names: tuple[str, ...]
    time: Floats | None  # (K,) s
    phase: Floats  # (K,)
    stance: Integers  # (K,)
    joint_orientation: Floats  # (K, J, 4)
    by_contact: bool = False  # phases are those of the gait cycle between contacts of the left foot, no controller's
    period: float = 0.0  # s, of these cycles; 0: not known

    def window(self, start: float) -> JointMotion:
        """The frames at or after a time, s; all where there are no times."""
        if self.time is None:
            return self
        on = self.time >= start
        return replace(
            self,
            time=self.time[on],
            phase=self.phase[on],
            stance=self.stance[on],
            joint_orientation=self.joint_orientation[on],
        )


def read(path: str | Path, character: Character) -> JointMotion:
    """Read the motion of the joints that a character has.

    Args:
        character: without free parameters.

    Raises:
        ResultError: no such file, no `.npz` file, damaged; an array is missing, has another shape, or holds something
            else than finite numbers. Python objects are never read.
    """
    names = [name for name, joint in character.joints.items() if joint_type(joint).moves]
    arrays = _load(path, {*FRAMES, *ORIGINAL, *names})
    try:
        if "joint_quat" in arrays:
            arrays = _translated(arrays)
        return _motion({name: arrays[name] for name in (*FRAMES, *names) if name in arrays}, names, character)
    except ValueError as error:
        raise ResultError(f"{path}: {error}") from None


def _load(path: str | Path, wanted: Collection[str]) -> dict[str, NDArray[np.generic]]:
    """The wanted arrays of an archive, as far as it has them."""
    try:
        return arrays_of(path, wanted)
    except DamagedArchive as error:
        raise ResultError(f"{path}: {error}") from None


def _translated(arrays: dict[str, NDArray[np.generic]]) -> dict[str, NDArray[np.generic]]:
    """The arrays of a recording of the original program by the names used here; ValueError if one does not fit."""
    for name in ORIGINAL:
        if name not in arrays:
            raise ValueError(f"array {name!r} is missing, which goes with 'joint_quat'")
    joints, quaternions = arrays["joint_names"], arrays["joint_quat"]
    if joints.dtype.kind not in "US" or joints.ndim != 1:
        raise ValueError(f"'joint_names' must be a row of names, has shape {joints.shape} and type {joints.dtype}")
    expected = (*arrays["t"].shape, len(joints), 4)
    if quaternions.shape != expected:
        raise ValueError(f"'joint_quat' has shape {quaternions.shape}, not {expected}")
    by_name = {str(name): quaternions[:, index, [1, 2, 3, 0]] for index, name in enumerate(joints.astype(str))}
    return by_name | {"time": arrays["t"], "phase": arrays["phi"], "stance": arrays["stance"]}


def _motion(arrays: dict[str, NDArray[np.generic]], names: list[str], character: Character) -> JointMotion:
    """The motion; ValueError if the arrays do not fit."""
    numbers = {name: _numbers(name, array) for name, array in arrays.items()}
    phase, stance = steps(numbers)
    present = tuple(name for name in names if name in numbers)
    if not present:
        raise ValueError(f"no array has the name of a joint; the character's joints are {', '.join(names)}")
    for name in ("time", "phase", "stance"):
        if name in numbers and numbers[name].shape != phase.shape:
            raise ValueError(f"{name!r} has shape {numbers[name].shape}, not {phase.shape}")
    period = _period(numbers) if "period" in numbers else 0.0
    orientations = [_orientation(name, numbers[name], character.joints[name], len(phase)) for name in present]
    joints = np.stack(orientations, axis=1)
    return JointMotion(present, numbers.get("time"), phase, stance, joints, "cycle" in numbers, period)


def _period(numbers: dict[str, Floats]) -> float:
    """The period of a cycle, s; ValueError if it is none."""
    if "cycle" not in numbers:
        raise ValueError("'period' goes with 'cycle'")
    if numbers["period"].size != 1:
        raise ValueError(f"'period' is one number, has shape {numbers['period'].shape}")
    period = float(numbers["period"].item())
    if not SHORTEST <= period <= LONGEST:
        raise ValueError(f"'period' is {SHORTEST:g} to {LONGEST:g} s, not {period:g}")
    return period


def _numbers(name: str, array: NDArray[np.generic]) -> Floats:
    """The array as float64, if it holds finite numbers."""
    if array.dtype.kind not in "biuf":
        raise ValueError(f"{name!r} must hold numbers, has type {array.dtype}")
    numbers = array.astype(np.float64)
    if not np.isfinite(numbers).all():
        raise ValueError(f"{name!r} holds a value that is not finite")
    return numbers


def steps(numbers: dict[str, Floats]) -> tuple[Floats, Integers]:
    """Phase and stance of the frames, given as such or over the gait cycle; ValueError if they do not fit."""
    if ("cycle" in numbers) == ("phase" in numbers):
        raise ValueError("give either 'phase' and 'stance', or 'cycle'")
    for name in ("stance",) if "phase" in numbers else ():
        if name not in numbers:
            raise ValueError(f"array {name!r} is missing, which goes with 'phase'")
    name, largest = ("phase", LARGEST_PHASE) if "phase" in numbers else ("cycle", 1.0)
    values = numbers[name]
    if values.ndim != 1 or not len(values):
        raise ValueError(f"{name!r} must be a row of numbers, one a frame, has shape {values.shape}")
    if values.min() < 0.0 or values.max() > largest:
        raise ValueError(f"{name!r} goes from 0 to 1, not from {values.min():g} to {values.max():g}")
    if name == "phase":
        if not np.isin(numbers["stance"], (0.0, 1.0)).all():
            raise ValueError("'stance' must be 0 (left) or 1 (right)")
        return values, numbers["stance"].astype(np.int32)
    doubled = 2.0 * (values % 1.0)
    return doubled % 1.0, doubled.astype(np.int32)


def _orientation(name: str, numbers: Floats, joint: Joint, frames: int) -> Floats:
    """Orientation (K, 4) of a joint's child in its parent, from that or from angles."""
    if numbers.shape == (frames, 4):
        length = np.linalg.norm(np.clip(numbers, -2.0, 2.0), axis=1)  # the square of more may be infinite
        if np.abs(length - 1.0).max() > QUATERNION_ERROR:
            raise ValueError(f"{name!r} holds quaternions that are not of unit length")
        return numbers
    kind = joint_type(joint)
    count = len(kind.angles)
    shape = (frames,) if count == 1 else (frames, count)
    if numbers.shape != shape:
        expected = f"{shape} for the angles of a {joint.type} joint, or {(frames, 4)} for quaternions"
        raise ValueError(f"{name!r} has shape {numbers.shape}; expected {expected}")
    if np.abs(numbers).max() > LARGEST_ANGLE:
        raise ValueError(f"{name!r} goes up to {np.abs(numbers).max():g}; angles are in rad")
    return kind.turned(joint, numbers.reshape(frames, count))
