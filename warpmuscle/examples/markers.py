"""Markers on an arm and a trunk, placed by known angles: throws as a motion capture system writes them."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about, multiply, rotate
from warpmuscle.examples.motions import COLUMNS, THROWS

STILL = 0.4  # s before the throw
UPPER_ARM, FOREARM, HAND = 0.3, 0.26, 0.09  # m
PRONATION = np.radians(85.0)  # with which the wrist bends in the plane of the throw
RIGHT, UP, FORWARD = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # of axes x forwards, z up
PAIRED = 0.02  # m, from the middle of a joint to a marker beside it


def marker_files() -> Iterable[tuple[str, str]]:
    """Two throws with markers in the centres of joints, z up, and one with markers beside them, y up."""
    for number in (1, 2):
        yield f"markers/throw{number}.csv", _table(*placed(THROWS[number - 1]))
    time, places = placed(THROWS[2])
    renamed = {"R_SHOULDER": "RSHO", "L_SHOULDER": "LSHO", "R_HIP": "RASI", "L_HIP": "LASI", "R_1STFINGER": "RFIN1",
               "R_5THFINGER": "RFIN5"}  # fmt: skip
    named = {renamed[name]: place for name, place in places.items() if name in renamed}
    for name, pair in (("R_ELBOW", ("RELB", "RELBM")), ("R_WRIST", ("RWRA", "RWRB"))):
        named |= {one: places[name] + sign * PAIRED * RIGHT for one, sign in zip(pair, (1.0, -1.0), strict=True)}
    upright = {name: place[:, [0, 2, 1]] * [1.0, 1.0, -1.0] for name, place in named.items()}
    yield "trial.trc", _trc("trial.trc", time, upright)


def placed(throw: Floats) -> tuple[Floats, dict[str, Floats]]:
    """Times and places (T, 3) of markers, m, by name, of a throw with rows of `COLUMNS`."""
    rate = round(1.0 / (throw[1, 0] - throw[0, 0]))
    rows = np.concatenate([np.repeat(throw[:1], round(STILL * rate), axis=0), throw])
    time = np.arange(len(rows)) / rate
    shoulder, elbow, wrist, trunk = np.radians(rows[:, [COLUMNS.index(f"{name}_deg") for name in (
        "shoulder", "elbow", "wrist", "trunk_pitch")]]).T  # fmt: skip
    zero = np.zeros((len(rows), 3))
    pitch = about(RIGHT, -trunk)
    upper = multiply(pitch, about(RIGHT, shoulder))
    fore = multiply(multiply(upper, about(RIGHT, elbow)), about(UP, np.full(len(rows), PRONATION)))
    hand = multiply(fore, about(FORWARD, wrist))
    middle = rows[:, [5]] * FORWARD + rows[:, [6]] * UP
    across = rotate(pitch, zero + 0.2 * RIGHT)
    hips = middle - rotate(pitch, zero + 0.5 * UP)
    points = {"R_SHOULDER": middle, "L_SHOULDER": middle - 2.0 * across}
    points |= {"R_HIP": hips - 0.5 * across, "L_HIP": hips - 1.5 * across}
    points["R_ELBOW"] = middle - rotate(upper, zero + UPPER_ARM * UP)
    points["R_WRIST"] = points["R_ELBOW"] - rotate(fore, zero + FOREARM * UP)
    for name, side in (("R_1STFINGER", 0.03), ("R_5THFINGER", -0.03)):
        points[name] = points["R_WRIST"] + rotate(hand, zero - HAND * UP + side * FORWARD)
    return time, points


def _rows(first: Floats, places: Mapping[str, Floats], scale: float, delimiter: str) -> str:
    text = io.StringIO()
    columns = np.column_stack([first, *(scale * place for place in places.values())])
    np.savetxt(text, columns, delimiter=delimiter, fmt="%.5f")
    return text.getvalue()


def _table(time: Floats, places: Mapping[str, Floats]) -> str:
    names = [f"{name}_{axis}" for name in places for axis in "xyz"]
    return ",".join(["time_s", *names]) + "\n" + _rows(time, places, 1.0, ",")


def _trc(name: str, time: Floats, places: Mapping[str, Floats]) -> str:
    """The text of a .trc file, mm."""
    rate, count = round(1.0 / (time[1] - time[0])), len(time)
    head = ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units", "OrigDataRate", "OrigDataStartFrame",
            "OrigNumFrames"]  # fmt: skip
    values = [rate, rate, count, len(places), "mm", rate, 1, count]
    axes = [f"{axis}{number}" for number in range(1, len(places) + 1) for axis in "XYZ"]
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{name}", "\t".join(head), "\t".join(map(str, values)),
        "Frame#\tTime\t" + "\t\t\t".join(places), "\t\t" + "\t".join(axes), "",
    ]  # fmt: skip
    body = _rows(time, places, 1000.0, "\t").splitlines()
    return "\n".join([*lines, *(f"{number}\t{row}" for number, row in enumerate(body, 1))]) + "\n"
