"""Recorded motions from tables or NumPy files.

A table (CSV, or OpenSim's .mot and .sto) has a header and a row a sample: a column of time (`time`, `time_s` or `t`,
in s, or `time_ms`) and one for each joint, named by it, such as `elbow`, `elbow_deg` or `elbow_flexion_rad`. `Elbow
flexion [deg]` is the same as `elbow_flexion_deg`. If none of these names tells the unit, and no line inDegrees, angles
beyond 2 pi in one of them mean degrees in all. Optional, else zero: how far the trunk leans forwards as
`trunk_pitch_deg`, or the angle of the upper arm to gravity as `shoulder_flexion_gravity_deg`, from which that follows;
the shoulder's place as `shoulder_forward_m`, `shoulder_up_m` (or `_cm`, `_mm`). Short gaps are bridged, and whole
turns taken out of angles.

A `.npz` file holds M motions: `time` (T,), and (M, T) arrays named as those columns, of degrees unless `_rad`;
`trial` (M,) names them; keypoints in m, x forward and z up, as `keypoint_pos_m` (M, T, k, 3) with names `keypoints`
(k,), of which R_SHOULDER gives the shoulder's place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from warpmuscle.core.archive import DamagedArchive, read_arrays
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.files import check_regular, unreadable
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.columns import LENGTHS, TIMES, Columns, with_units
from warpmuscle.synergy.tables import read_table
from warpmuscle.throw.motion import PITCH, PLACE, ArmMotion

LEAST_SAMPLES = 12
LONGEST = 60.0  # s
TO_GRAVITY = "shoulder_flexion_gravity"
SHOULDER_POINT = "R_SHOULDER"
TURN = 2.0 * np.pi  # rad; numbers within it are radians, or degrees of what hardly moves
JUMP = 1.5 * np.pi  # rad from sample to sample, which no joint turns, but angles between -180 and 180 deg do
ROUNDED = 0.02  # rad, by which angles that are wrapped may extend over more than a turn
ANGLE_OF = ("", "_flexion", "_angle", "_flexion_angle")  # what may follow a joint in the name of its column
MOST_PITCH, SAME_PITCH = 100.0, 5.0  # deg
FASTEST_SHOULDER = 20.0  # m/s, faster than anybody runs


def read(path: str | Path, joints: Sequence[str]) -> list[ArmMotion]:
    """The motions in a table of text or a `.npz` file, angles in the order of `joints`.

    Raises:
        SignalError: the file cannot be read, lacks a column, or holds anything but finite numbers at increasing times.
    """
    path = Path(path)
    if path.suffix.lower() == ".npz":
        return _read_npz(path, joints)
    return [_motion(Columns.of_table(read_table(path)), joints)]


def _read_npz(path: Path, joints: Sequence[str]) -> list[ArmMotion]:
    try:
        check_regular(path)
        with open(path, "rb") as file:
            arrays = {name.lower(): array for name, array in read_arrays(file).items()}
    except OSError as error:
        raise SignalError(unreadable(error), file=path) from None
    except DamagedArchive as error:
        raise SignalError(str(error), file=path) from None
    clock = next((name for name in TIMES if name in arrays), "")
    time = arrays.get(clock)
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
        columns = {clock: time}
        for name, a in arrays.items():
            if a.shape == (count, len(time)):
                columns[name if name.endswith(("_deg", "_rad", *filter(None, LENGTHS))) else f"{name}_deg"] = a[index]
        if keypoints is not None and SHOULDER_POINT in points:
            place = keypoints[index, :, points.index(SHOULDER_POINT)]
            columns["shoulder_forward_m"], columns["shoulder_up_m"] = place[:, 0], place[:, 2]
        motions.append(_motion(Columns(path, str(trials[index]), list(columns), None, columns), joints))
    return motions


def _motion(columns: Columns, joints: Sequence[str]) -> ArmMotion:
    time = columns.time()
    _check_time(columns, time)
    chosen = {}
    for joint in joints:
        column = columns.only(f"the angle of {joint!r}", with_units([f"{joint}{more}" for more in ANGLE_OF]))
        if column is None:
            raise columns.error(f"no column of the angle of {joint!r}; name one `{joint}_deg`; {columns.listed()}")
        chosen[joint] = column
    for name in (PITCH, TO_GRAVITY):
        column = columns.only(f"the angle {name!r}", with_units([name]))
        if column is not None:
            chosen[name] = column
    angle = _in_radians(columns, chosen, joints, time)
    absent: tuple[str, ...] = ()
    pitch = _pitch(columns, chosen, angle)
    if pitch is None:
        pitch, absent = np.zeros_like(time), (PITCH,)
    place = np.zeros((len(time), 2))
    for axis, name in enumerate(PLACE):
        values = columns.place(name, time)
        if values is None:
            absent += (name,)
        else:
            place[:, axis] = values
            _check_place(columns, name, time, values)
    angles = np.stack([angle[joint] for joint in joints], axis=1)
    return ArmMotion(columns.motion, float(time[0]), time - time[0], angles, pitch, place, absent, columns.bridged)


def _pitch(columns: Columns, chosen: Mapping[str, str], angle: Mapping[str, Floats]) -> Floats | None:
    """How far the trunk leans forwards, rad, by its own column or the angle to gravity; None if neither tells."""
    if TO_GRAVITY not in angle or "shoulder" not in angle:
        return angle.get(PITCH)
    pitch = _without_turns(angle["shoulder"] - angle[TO_GRAVITY])
    most = float(np.degrees(np.abs(pitch).max()))
    if most > MOST_PITCH:
        raise columns.error(
            f"the trunk would lean by {most:.0f} deg, the angle of the shoulder less this one; are both in the same "
            "unit?", chosen[TO_GRAVITY],
        )  # fmt: skip
    if PITCH not in angle:
        return pitch
    apart = float(np.degrees(np.abs(angle[PITCH] - pitch).max()))
    if apart > SAME_PITCH:
        raise columns.error(
            f"is up to {apart:.0f} deg from the angle of the shoulder less {chosen[TO_GRAVITY]!r}, which is how far "
            "the trunk leans forwards; leave one of them out", chosen[PITCH],
        )  # fmt: skip
    return angle[PITCH]


def _in_radians(columns: Columns, chosen: Mapping[str, str], joints: Sequence[str], time: Floats) -> dict[str, Floats]:
    """Angles, rad, by the names of what they are of; refused if they cannot be in the unit that their columns name."""
    values = {name: columns.bridge(column, time) for name, column in chosen.items()}
    most = {name: float(np.abs(value).max()) for name, value in values.items()}
    degrees = [name for name in joints if chosen[name].endswith("_deg")]
    if degrees and all(most[name] <= TURN for name in degrees):
        raise columns.error(
            f"all angles of joints are within {max(most[name] for name in degrees):.3g} deg; if they are in radians, "
            f"name the column `{chosen[degrees[0]][:-4]}_rad`", chosen[degrees[0]],
        )  # fmt: skip
    plain = [name for name in chosen if not chosen[name].endswith(("_deg", "_rad"))]
    large = any(most[name] > TURN for name in plain)
    said = None if columns.table is None else columns.table.degrees
    if said is False and large:
        name = max(plain, key=lambda name: most[name])
        raise columns.error(f"goes up to {most[name]:.4g} where the header says inDegrees=no", chosen[name])
    found = {}
    for name, column in chosen.items():
        if column.endswith("_rad") and most[name] > 2.0 * TURN:
            what = f"goes up to {most[name]:.4g} rad; if it is in degrees, name the column `{column[:-4]}_deg`"
            raise columns.error(what, column)
        in_degrees = column.endswith("_deg") or (name in plain and (large if said is None else said))
        found[name] = _without_turns(np.radians(values[name]) if in_degrees else values[name])
    return found


def _without_turns(angle: Floats) -> Floats:
    """The same angle, rad, without jumps by a whole turn and by so many turns less that its mean is within a half."""
    if np.abs(np.diff(angle)).max() > JUMP and np.ptp(angle) < TURN + ROUNDED:
        angle = np.unwrap(angle, discont=JUMP)
    turns = round(float(np.mean(angle)) / TURN)
    return angle - TURN * turns if turns else angle


def _check_place(columns: Columns, name: str, time: Floats, values: Floats) -> None:
    fastest = float(np.abs(np.diff(values) / np.diff(time)).max())
    if fastest > FASTEST_SHOULDER:
        raise columns.error(
            f"the place {name!r} moves at up to {fastest:.3g} m/s; if it is in mm, name the column `{name}_mm`"
        )


def _check_time(columns: Columns, time: Floats) -> None:
    if len(time) < LEAST_SAMPLES:
        raise columns.error(f"{number_of(len(time), 'sample')}; a motion takes at least {LEAST_SAMPLES}")
    steps = np.diff(time)
    if np.any(steps <= 0.0):
        row = int(np.flatnonzero(steps <= 0.0)[0])
        what = f"goes from {time[row]:g} to {time[row + 1]:g} s"
        if steps[row] == 0.0:
            what = f"{time[row]:g} s stands twice; are times rounded, or rows there twice?"
        raise columns.error(f"time must increase, but {what}", "", columns.line(row + 1))
    if time[-1] - time[0] > LONGEST:
        raise columns.error(
            f"{time[-1] - time[0]:g} s long; times are in seconds, at most {LONGEST:g} of them; name a column in "
            "milliseconds `time_ms`"
        )
