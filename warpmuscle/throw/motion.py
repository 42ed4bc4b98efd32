"""Recorded motions: angles of joints over time from tables or NumPy files, resampled and differentiated.

A table (CSV, or OpenSim's .mot and .sto) has a header and a row a sample: a column of time (`time`, `time_s` or `t`, in
s) and one for each joint, named by it, such as `elbow`, `elbow_deg` or `elbow_flexion_rad`. Without `_deg` or `_rad`,
angles beyond 2 pi mean degrees. Optional, else zero: how far the trunk leans forwards as `trunk_pitch_deg`, or the
angle of the upper arm to gravity as `shoulder_flexion_gravity_deg`, from which that follows; the shoulder's place as
`shoulder_forward_m`, `shoulder_up_m`.

A `.npz` file holds M motions: `time` (T,), and (M, T) arrays named as those columns, of degrees unless `_rad`;
`trial` (M,) names them; keypoints in m, x forward and z up, as `keypoint_pos_m` (M, T, k, 3) with names `keypoints`
(k,), of which R_SHOULDER gives the shoulder's place.
"""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from warpmuscle.arrays import Floats
from warpmuscle.errors import SignalError
from warpmuscle.formats.files import unreadable
from warpmuscle.synergy.tables import Table, read_table

RATE = 100.0  # Hz, of everything that is compared
PADDING = 0.1  # s, mirrored about each end, so that second derivatives there come from data on both sides
LEAST_SAMPLES = 12
LONGEST = 60.0  # s
TIME_NAMES = ("time", "time_s", "t", "t_s")
PITCH = "trunk_pitch"
TO_GRAVITY = "shoulder_flexion_gravity"
PLACE = ("shoulder_forward", "shoulder_up")
SHOULDER_POINT = "R_SHOULDER"


@dataclass(frozen=True)
class Motion:
    """A recorded motion as it was read: angles (S, J), rad, at increasing times (S,) from 0 on, s."""

    name: str
    start: float  # s, time of the first sample in its file
    time: Floats
    angles: Floats
    pitch: Floats  # (S,) of the trunk, forwards, rad
    place: Floats  # (S, 2) of the shoulder, forwards and up, m


@dataclass(frozen=True)
class Motions:
    """n motions resampled to the same times, t = 0 at their starts; beyond its end a motion stands still.

    Each of `angles` (n, T, J), `pitch` (n, T) and `place` (n, T, 2) is followed by its first and second derivative in
    the tuple of the same name.
    """

    names: tuple[str, ...]
    time: Floats  # (T,) s
    valid: Floats  # (n, T) 1 where a motion has data, else 0
    angles: tuple[Floats, Floats, Floats]
    pitch: tuple[Floats, Floats, Floats]
    place: tuple[Floats, Floats, Floats]

    def __len__(self) -> int:
        return len(self.names)

    def rows(self, which: Sequence[int]) -> Motions:
        """Some of them."""
        index = list(which)

        def pick(parts: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats, Floats]:
            return parts[0][index], parts[1][index], parts[2][index]

        names = tuple(self.names[i] for i in index)
        return Motions(names, self.time, self.valid[index], pick(self.angles), pick(self.pitch), pick(self.place))


def read(path: str | Path, joints: Sequence[str]) -> list[Motion]:
    """The motions in a table of text or a `.npz` file, angles in the order of `joints`.

    Raises:
        SignalError: the file cannot be read, lacks a column, or holds anything but finite numbers at increasing times.
    """
    path = Path(path)
    if path.suffix.lower() == ".npz":
        return _read_npz(path, joints)
    table = read_table(path)
    columns = _Columns(path, path.stem, [name.lower() for name in table.names], table)
    return [_motion(columns, joints)]


@dataclass(frozen=True)
class _Columns:
    """Named columns of one motion, read when they are asked for."""

    path: Path
    motion: str
    names: list[str]
    table: Table | None = None
    arrays: dict[str, Floats] = field(default_factory=dict)

    def get(self, *names: str) -> Floats | None:
        """The first of these columns that there is, finite throughout."""
        for name in names:
            if name not in self.names:
                continue
            column = self.arrays[name] if self.table is None else self.table.columns([self.names.index(name)])[:, 0]
            wrong = np.flatnonzero(~np.isfinite(column))
            if len(wrong):
                line = 0 if self.table is None else int(self.table.lines[wrong[0]])
                raise self.error(f"the value is {column[wrong[0]]}, not a finite number", name, line)
            return np.asarray(column, dtype=np.float64)
        return None

    def error(self, message: str, column: str = "", line: int = 0) -> SignalError:
        inside = f"motion {self.motion}: " if self.table is None else ""
        return SignalError(f"{inside}{f'column {column!r}: ' if column else ''}{message}", "", self.path, line)


def _read_npz(path: Path, joints: Sequence[str]) -> list[Motion]:
    try:
        with np.load(path, allow_pickle=False) as data:
            arrays = {name.lower(): data[name] for name in data.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise SignalError(unreadable(error), file=path) from None
    time = next((arrays[name] for name in TIME_NAMES if name in arrays), None)
    if time is None or time.ndim != 1:
        raise SignalError("no array `time` (T,)", file=path)
    count = max((len(a) for a in arrays.values() if a.ndim == 2 and a.shape[1] == len(time)), default=0)
    if count == 0:
        raise SignalError(f"no arrays of angles (motions, {len(time)})", file=path)
    trials = arrays.get("trial", np.arange(count))
    keypoints = arrays.get("keypoint_pos_m")
    points = [str(name) for name in arrays.get("keypoints", ())]
    motions = []
    for index in range(count):
        columns = {"time": time}
        for name, a in arrays.items():
            if a.shape == (count, len(time)) and a.dtype.kind == "f":
                columns[name if name.endswith(("_deg", "_rad", "_m")) else f"{name}_deg"] = a[index]
        if keypoints is not None and keypoints.ndim == 4 and SHOULDER_POINT in points:
            place = keypoints[index, :, points.index(SHOULDER_POINT)]
            columns["shoulder_forward_m"], columns["shoulder_up_m"] = place[:, 0], place[:, 2]
        motions.append(_motion(_Columns(path, str(trials[index]), list(columns), None, columns), joints))
    return motions


def _motion(columns: _Columns, joints: Sequence[str]) -> Motion:
    time = columns.get(*TIME_NAMES)
    if time is None:
        raise columns.error("no column of time; name one `time_s`")
    _check_time(columns, time)
    angles = []
    for joint in joints:
        angle = _angle(columns, joint, f"{joint}_flexion")
        if angle is None:
            raise columns.error(f"no column of the angle of {joint!r}; name one `{joint}_deg`")
        angles.append(angle)
    pitch = _angle(columns, PITCH)
    if pitch is None:
        to_gravity, shoulder = _angle(columns, TO_GRAVITY), _angle(columns, "shoulder", "shoulder_flexion")
        pitch = np.zeros_like(time) if to_gravity is None or shoulder is None else shoulder - to_gravity
    place = np.zeros((len(time), 2))
    for axis, name in enumerate(PLACE):
        column = columns.get(f"{name}_m", name)
        if column is not None:
            place[:, axis] = column
    return Motion(columns.motion, float(time[0]), time - time[0], np.stack(angles, axis=1), pitch, place)


def _check_time(columns: _Columns, time: Floats) -> None:
    if len(time) < LEAST_SAMPLES:
        raise columns.error(f"{len(time)} samples; a motion takes at least {LEAST_SAMPLES}")
    steps = np.diff(time)
    if np.any(steps <= 0.0):
        row = int(np.flatnonzero(steps <= 0.0)[0])
        line = 0 if columns.table is None else int(columns.table.lines[row + 1])
        raise columns.error(f"time must increase, but goes from {time[row]:g} to {time[row + 1]:g} s", "", line)
    if time[-1] - time[0] > LONGEST:
        raise columns.error(f"{time[-1] - time[0]:g} s long; times are in seconds, at most {LONGEST:g} of them")


def _angle(columns: _Columns, *names: str) -> Floats | None:
    """A column of angles, rad, under one of these names with or without its unit."""
    for name in names:
        degrees, radians, plain = columns.get(f"{name}_deg"), columns.get(f"{name}_rad"), columns.get(name)
        if degrees is not None:
            return np.radians(degrees)
        if radians is not None:
            return radians
        if plain is not None:
            return np.radians(plain) if np.abs(plain).max() > 2.0 * np.pi else plain
    return None


def resample(motions: Sequence[Motion], rate: float = RATE) -> Motions:
    """Motions at the same times from quintic splines, whose first two derivatives are smooth up to the ends."""
    longest = max(motion.time[-1] for motion in motions)
    time = np.arange(int(np.floor(longest * rate + 1e-6)) + 1) / rate
    shape = (len(motions), len(time))
    valid = np.zeros(shape)
    joints = motions[0].angles.shape[1]
    angles, place = (tuple(np.zeros((*shape, k)) for _ in range(3)) for k in (joints, 2))
    pitch = tuple(np.zeros(shape) for _ in range(3))
    for row, motion in enumerate(motions):
        inside = time <= motion.time[-1] + 1e-9
        valid[row] = inside
        for source, target in ((motion.angles, angles), (motion.pitch, pitch), (motion.place, place)):
            curve = _spline(motion.time, source)
            for order in range(3):
                target[order][row, inside] = curve(time[inside], nu=order)
            target[0][row, ~inside] = target[0][row, inside][-1]
    names = tuple(motion.name for motion in motions)
    return Motions(
        names, time, valid,
        (angles[0], angles[1], angles[2]), (pitch[0], pitch[1], pitch[2]), (place[0], place[1], place[2]),
    )  # fmt: skip


def _spline(time: Floats, values: Floats) -> Any:
    """A quintic spline through values (S, ...), continued beyond both ends by point reflection of the data there."""
    count = int(np.clip(np.sum(time < time[0] + PADDING), 3, len(time) - 1))
    left, right = slice(count, 0, -1), slice(-2, -count - 2, -1)
    times = np.concatenate([2.0 * time[0] - time[left], time, 2.0 * time[-1] - time[right]])
    padded = np.concatenate([2.0 * values[0] - values[left], values, 2.0 * values[-1] - values[right]])
    return make_interp_spline(times, padded, k=5)
