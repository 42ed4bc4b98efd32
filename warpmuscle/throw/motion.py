"""Recorded motions: angles of joints over time from CSV or NumPy files, resampled and differentiated.

A CSV has a header and a row a sample: a column of time (`time`, `time_s` or `t`, in s) and one for each joint, named by
it, such as `elbow`, `elbow_deg` or `elbow_flexion_rad`. Without `_deg` or `_rad`, angles beyond 2 pi mean degrees.
Optional, else zero: the trunk's pitch as `trunk_pitch_deg`, or the angle of the upper arm to gravity as
`shoulder_flexion_gravity_deg`, from which it follows; the shoulder's place as `shoulder_forward_m`, `shoulder_up_m`.

A `.npz` file holds many motions: `time` (T,), and (M, T) arrays named as those columns, of degrees unless `_rad`;
`trial` (M,) names them; keypoints in m, x forward and z up, as `keypoint_pos_m` (M, T, k, 3) with names `keypoints`
(k,), of which R_SHOULDER gives the shoulder's place.
"""

from __future__ import annotations

import csv
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import make_interp_spline

from warpmuscle.arrays import Floats
from warpmuscle.errors import ResultError
from warpmuscle.formats.files import unreadable

RATE = 100.0  # Hz, of everything that is compared
PADDING = 0.1  # s, mirrored about each end, so that second derivatives there come from data on both sides
LEAST_SAMPLES = 12
LONGEST = 60.0  # s
TIME_NAMES = ("time", "time_s", "t", "t_s")
PITCH = "trunk_pitch"
TO_GRAVITY = "shoulder_flexion_gravity"
PLACE = ("shoulder_forward", "shoulder_up")


@dataclass(frozen=True)
class Motion:
    """A recorded motion as it was read: angles (S, J), rad, at increasing times (S,), s."""

    name: str
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
        return Motions(
            names, self.time, self.valid[index], pick(self.angles), pick(self.pitch), pick(self.place)
        )


def read(path: str | Path, joints: Sequence[str]) -> list[Motion]:
    """The motions in a CSV or `.npz` file, angles in the order of `joints`.

    Raises:
        ResultError: the file cannot be read, lacks a column, or holds anything but finite numbers at increasing times.
    """
    path = Path(path)
    try:
        if path.suffix.lower() == ".npz":
            return _read_npz(path, joints)
        return [_read_csv(path, joints)]
    except (OSError, UnicodeDecodeError, zipfile.BadZipFile) as error:
        raise ResultError(f"{path}: {unreadable(error)}") from None


def _read_csv(path: Path, joints: Sequence[str]) -> Motion:
    with open(path, newline="", encoding="utf-8-sig") as file:
        lines = [line for line in csv.reader(file) if any(cell.strip() for cell in line)]
    if not lines:
        raise ResultError(f"{path}: the file is empty")
    header = [cell.strip().lower() for cell in lines[0]]
    columns: dict[str, Floats] = {name: np.empty(len(lines) - 1) for name in header}
    for number, line in enumerate(lines[1:], start=2):
        if len(line) != len(header):
            raise ResultError(f"{path}: row {number} has {len(line)} values, the header has {len(header)}")
        for name, cell in zip(header, line, strict=True):
            try:
                columns[name][number - 2] = float(cell)
            except ValueError:
                columns[name][number - 2] = np.nan
    time = next((columns[name] for name in TIME_NAMES if name in columns), None)
    if time is None:
        raise ResultError(f"{path}: no column of time; name one `time_s`")
    return _motion(path, path.stem, time, columns, joints)


def _read_npz(path: Path, joints: Sequence[str]) -> list[Motion]:
    try:
        with np.load(path, allow_pickle=False) as data:
            arrays = {name.lower(): data[name] for name in data.files}
    except (ValueError, EOFError) as error:
        raise ResultError(f"{path}: not a file of plain NumPy arrays: {error}") from None
    time = next((arrays[name] for name in TIME_NAMES if name in arrays), None)
    if time is None or time.ndim != 1:
        raise ResultError(f"{path}: no array `time` (T,)")
    count = max((len(a) for a in arrays.values() if a.ndim == 2 and a.shape[1] == len(time)), default=0)
    if count == 0:
        raise ResultError(f"{path}: no arrays of angles (motions, {len(time)})")
    trials = arrays.get("trial", np.arange(count))
    keypoints = arrays.get("keypoint_pos_m")
    names = [str(name) for name in arrays.get("keypoints", ())]
    motions = []
    for index in range(count):
        columns = {}
        for name, a in arrays.items():
            if a.shape == (count, len(time)) and a.dtype.kind == "f":
                columns[name if name.endswith(("_deg", "_rad", "_m")) else f"{name}_deg"] = a[index].astype(float)
        if keypoints is not None and "R_SHOULDER" in names:
            place = keypoints[index, :, names.index("R_SHOULDER")].astype(float)
            columns["shoulder_forward_m"], columns["shoulder_up_m"] = place[:, 0], place[:, 2]
        motions.append(_motion(path, str(trials[index]), time.astype(float), columns, joints))
    return motions


def _motion(path: Path, name: str, time: Floats, columns: dict[str, Floats], joints: Sequence[str]) -> Motion:
    where = f"{path}, {name}" if name != path.stem else str(path)
    _check_time(where, time)
    angles = [_angle(where, columns, (joint, f"{joint}_flexion"), required=True) for joint in joints]
    pitch = _angle(where, columns, (PITCH,))
    if pitch is None:
        to_gravity = _angle(where, columns, (TO_GRAVITY,))
        shoulder = _angle(where, columns, ("shoulder", "shoulder_flexion"))
        pitch = np.zeros_like(time) if to_gravity is None or shoulder is None else shoulder - to_gravity
    place = np.zeros((len(time), 2))
    for axis, key in enumerate(PLACE):
        column = columns.get(f"{key}_m", columns.get(key))
        if column is not None:
            place[:, axis] = _finite(where, key, column)
    return Motion(name, time - time[0], np.stack([a for a in angles if a is not None], axis=1), pitch, place)


def _check_time(where: str, time: Floats) -> None:
    _finite(where, "time", time)
    if len(time) < LEAST_SAMPLES:
        raise ResultError(f"{where}: {len(time)} samples; a motion takes at least {LEAST_SAMPLES}")
    steps = np.diff(time)
    if np.any(steps <= 0.0):
        row = int(np.flatnonzero(steps <= 0.0)[0])
        raise ResultError(f"{where}: time does not increase from {time[row]:g} to {time[row + 1]:g} s")
    if time[-1] - time[0] > LONGEST:
        raise ResultError(f"{where}: {time[-1] - time[0]:g} s long; times are seconds, at most {LONGEST:g} of them")


def _angle(where: str, columns: dict[str, Floats], names: Sequence[str], required: bool = False) -> Floats | None:
    """A column of angles, rad, under one of these names with or without its unit."""
    for name in names:
        if f"{name}_deg" in columns:
            return np.radians(_finite(where, f"{name}_deg", columns[f"{name}_deg"]))
        if f"{name}_rad" in columns:
            return _finite(where, f"{name}_rad", columns[f"{name}_rad"])
        if name in columns:
            angle = _finite(where, name, columns[name])
            return np.radians(angle) if np.abs(angle).max() > 2.0 * np.pi else angle
    if required:
        raise ResultError(f"{where}: no column of the angle of {names[0]!r}; name one `{names[0]}_deg`")
    return None


def _finite(where: str, name: str, column: Floats) -> Floats:
    wrong = np.flatnonzero(~np.isfinite(column))
    if len(wrong):
        raise ResultError(f"{where}: {name} is not a finite number in sample {wrong[0] + 1}")
    return column


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


def _spline(time: Floats, values: Floats) -> object:
    """A quintic spline through values (S, ...), continued beyond both ends by point reflection of the data there."""
    count = int(np.clip(np.sum(time < time[0] + PADDING), 3, len(time) - 1))
    left, right = slice(count, 0, -1), slice(-2, -count - 2, -1)
    times = np.concatenate([2.0 * time[0] - time[left], time, 2.0 * time[-1] - time[right]])
    padded = np.concatenate([2.0 * values[0] - values[left], values, 2.0 * values[-1] - values[right]])
    return make_interp_spline(times, padded, k=5)
