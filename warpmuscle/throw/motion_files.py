"""Recorded motions from tables or NumPy files.

A table (CSV, or OpenSim's .mot and .sto) has a header and a row a sample: a column of time (`time`, `time_s` or `t`, in
s) and one for each joint, named by it, such as `elbow`, `elbow_deg` or `elbow_flexion_rad`. If none of these names
ends in `_deg` or `_rad`, angles beyond 2 pi in one of them mean degrees in all. Optional, else zero: how far the trunk
leans forwards as `trunk_pitch_deg`, or the angle of the upper arm to gravity as `shoulder_flexion_gravity_deg`, from
which that follows; the shoulder's place as `shoulder_forward_m`, `shoulder_up_m`.

A `.npz` file holds M motions: `time` (T,), and (M, T) arrays named as those columns, of degrees unless `_rad`;
`trial` (M,) names them; keypoints in m, x forward and z up, as `keypoint_pos_m` (M, T, k, 3) with names `keypoints`
(k,), of which R_SHOULDER gives the shoulder's place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from warpmuscle.core.archive import DamagedArchive, read_arrays
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.files import check_regular, unreadable
from warpmuscle.synergy.tables import Table, read_table
from warpmuscle.throw.motion import PITCH, PLACE, Motion

LEAST_SAMPLES = 12
LONGEST = 60.0  # s
TIME_NAMES = ("time", "time_s", "t", "t_s")
TO_GRAVITY = "shoulder_flexion_gravity"
SHOULDER_POINT = "R_SHOULDER"
TURN = 2.0 * np.pi  # rad; numbers within it are radians, or degrees of what hardly moves
MOST_PITCH = np.radians(100.0)


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

    def only(self, what: str, names: Sequence[str]) -> str | None:
        """The one of these columns that there is, None if there is none."""
        present = [name for name in self.names if name in names]
        if len(present) > 1:
            raise self.error(f"more than one column with {what}: {', '.join(present)}; leave one of them")
        return present[0] if present else None

    def get(self, name: str) -> Floats:
        """The values of a column, finite throughout."""
        column = self.arrays[name] if self.table is None else self.table.columns([self.names.index(name)])[:, 0]
        if column.dtype.kind not in "iuf":
            raise self.error(f"holds values of type {column.dtype}, not numbers", name)
        wrong = np.flatnonzero(~np.isfinite(column))
        if len(wrong):
            line = 0 if self.table is None else int(self.table.lines[wrong[0]])
            raise self.error(f"the value is {column[wrong[0]]}, not a finite number", name, line)
        return np.asarray(column, dtype=np.float64)

    def error(self, message: str, column: str = "", line: int = 0) -> SignalError:
        inside = f"motion {self.motion}: " if self.table is None else ""
        return SignalError(f"{inside}{f'column {column!r}: ' if column else ''}{message}", "", self.path, line)


def _read_npz(path: Path, joints: Sequence[str]) -> list[Motion]:
    try:
        check_regular(path)
        with open(path, "rb") as file:
            arrays = {name.lower(): array for name, array in read_arrays(file).items()}
    except OSError as error:
        raise SignalError(unreadable(error), file=path) from None
    except DamagedArchive as error:
        raise SignalError(str(error), file=path) from None
    time = next((arrays[name] for name in TIME_NAMES if name in arrays), None)
    if time is None or time.ndim != 1:
        raise SignalError("no array `time` (T,)", file=path)
    count = max((len(a) for a in arrays.values() if a.ndim == 2 and a.shape[1] == len(time)), default=0)
    if count == 0:
        raise SignalError(f"no arrays of angles (motions, {len(time)})", file=path)
    trials = arrays.get("trial", np.arange(count))
    keypoints = arrays.get("keypoint_pos_m")
    points = [str(name) for name in np.ravel(arrays.get("keypoints", ()))]
    if np.shape(trials) != (count,):
        raise SignalError(f"`trial` has shape {np.shape(trials)}, not ({count},)", file=path)
    if keypoints is not None and keypoints.shape != (count, len(time), len(points), 3):
        wanted = f"({count}, {len(time)}, {len(points)}, 3)"
        raise SignalError(f"`keypoint_pos_m` has shape {keypoints.shape}, not {wanted}", file=path)
    motions = []
    for index in range(count):
        columns = {"time": time}
        for name, a in arrays.items():
            if a.shape == (count, len(time)):
                columns[name if name.endswith(("_deg", "_rad", "_m")) else f"{name}_deg"] = a[index]
        if keypoints is not None and SHOULDER_POINT in points:
            place = keypoints[index, :, points.index(SHOULDER_POINT)]
            columns["shoulder_forward_m"], columns["shoulder_up_m"] = place[:, 0], place[:, 2]
        motions.append(_motion(_Columns(path, str(trials[index]), list(columns), None, columns), joints))
    return motions


def _motion(columns: _Columns, joints: Sequence[str]) -> Motion:
    time_column = columns.only("times", TIME_NAMES)
    if time_column is None:
        raise columns.error("no column of time; name one `time_s`")
    time = columns.get(time_column)
    _check_time(columns, time)
    chosen = {}
    for joint in joints:
        column = columns.only(f"the angle of {joint!r}", _with_units(joint, f"{joint}_flexion"))
        if column is None:
            raise columns.error(f"no column of the angle of {joint!r}; name one `{joint}_deg`")
        chosen[joint] = column
    for name in (PITCH, TO_GRAVITY):
        column = columns.only(f"the angle {name!r}", _with_units(name))
        if column is not None:
            chosen[name] = column
    angle = _in_radians(columns, chosen, joints)
    pitch = np.zeros_like(time)
    absent: tuple[str, ...] = ()
    if PITCH in angle:
        pitch = angle[PITCH]
    elif TO_GRAVITY in angle and "shoulder" in angle:
        pitch = angle["shoulder"] - angle[TO_GRAVITY]
        if np.abs(pitch).max() > MOST_PITCH:
            raise columns.error(
                f"the trunk would lean by {np.degrees(np.abs(pitch).max()):.0f} deg, the angle of the shoulder less "
                "this one; are both in the same unit?", chosen[TO_GRAVITY],
            )  # fmt: skip
    else:
        absent = (PITCH,)
    place = np.zeros((len(time), 2))
    for axis, name in enumerate(PLACE):
        column = columns.only(f"the place {name!r}", (f"{name}_m", name))
        if column is None:
            absent += (name,)
        else:
            place[:, axis] = columns.get(column)
    angles = np.stack([angle[joint] for joint in joints], axis=1)
    return Motion(columns.motion, float(time[0]), time - time[0], angles, pitch, place, absent)


def _with_units(*names: str) -> list[str]:
    return [f"{name}{unit}" for name in names for unit in ("_deg", "_rad", "")]


def _in_radians(columns: _Columns, chosen: Mapping[str, str], joints: Sequence[str]) -> dict[str, Floats]:
    """Angles, rad, by the names of what they are of; refused if they cannot be in the unit that their columns name."""
    values = {name: columns.get(column) for name, column in chosen.items()}
    most = {name: float(np.abs(value).max()) for name, value in values.items()}
    degrees = [name for name in joints if chosen[name].endswith("_deg")]
    if degrees and all(most[name] <= TURN for name in degrees):
        raise columns.error(
            f"all angles of joints are within {max(most[name] for name in degrees):.3g} deg; if they are in radians, "
            f"name the column `{chosen[degrees[0]][:-4]}_rad`", chosen[degrees[0]],
        )  # fmt: skip
    plain = [name for name in chosen if not chosen[name].endswith(("_deg", "_rad"))]
    large = any(most[name] > TURN for name in plain)
    found = {}
    for name, column in chosen.items():
        if column.endswith("_rad") and most[name] > 2.0 * TURN:
            what = f"goes up to {most[name]:.4g} rad; if it is in degrees, name the column `{column[:-4]}_deg`"
            raise columns.error(what, column)
        in_degrees = column.endswith("_deg") or (name in plain and large)
        found[name] = np.radians(values[name]) if in_degrees else values[name]
    return found


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
