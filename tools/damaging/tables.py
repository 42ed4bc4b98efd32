"""Damages of coordinates, loads and EMG."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import numpy as np

from damaging.damage import Damage, beheaded, changed_line, cut, some, spliced
from damaging.trial import Columns, Trial

Change = Callable[[Trial, Random], None]


def _of(trial: Trial, what: str) -> Columns:
    return {"coordinates": trial.coordinates, "loads": trial.loads, "emg": trial.emg}[what]


def usual(what: str) -> list[Damage]:
    """What any table may have."""

    def no_number(trial: Trial, rng: Random) -> None:
        values = _of(trial, what).values
        values[rng.randrange(len(values)), rng.randrange(values.shape[1])] = rng.choice([np.nan, np.inf, -np.inf])

    def gap(trial: Trial, rng: Random) -> None:
        values = _of(trial, what).values
        values[some(len(values), rng), rng.randrange(values.shape[1])] = np.nan

    def twice(trial: Trial, rng: Random) -> None:
        columns = _of(trial, what)
        k = rng.randrange(len(columns.names))
        columns.names.append(columns.names[k])
        columns.values = np.column_stack([columns.values, 0.5 * columns.values[:, k]])

    def shuffled(trial: Trial, rng: Random) -> None:
        times = list(_of(trial, what).times)
        rng.shuffle(times)
        _of(trial, what).times = np.array(times)

    def same_time(trial: Trial, rng: Random) -> None:
        times = _of(trial, what).times
        times[rng.randrange(1, len(times))] = times[0]

    def no_time(trial: Trial, rng: Random) -> None:
        trial.edit(what, lambda data: data.replace(b"time", b"tme", 1))

    def word(trial: Trial, rng: Random) -> None:
        def edit(data: bytes) -> bytes:
            lines = data.split(b"\n")
            k = len(lines) - 2 - rng.randrange(5)
            lines[k] = lines[k].replace(b".", b"o", 2)
            return b"\n".join(lines)

        trial.edit(what, edit)

    def fewer_cells(trial: Trial, rng: Random) -> None:
        trial.edit(what, changed_line(-3, lambda line: line[: len(line) // 2]))

    def nothing(trial: Trial, rng: Random) -> None:
        _of(trial, what).keep([])

    def long_row(trial: Trial, rng: Random) -> None:
        trial.edit(what, changed_line(-3, lambda line: line + b"0" * 300_000))

    increase = r"times must increase"
    early = "" if what == "emg" else r"promises|empty|endheader|cells?|reach|not a number|no column"
    return [
        Damage("a cell is not a finite number", no_number, r"not a finite number"),
        Damage("gap", gap, r"not a finite number"),
        Damage("column twice", twice, r"two columns"),
        Damage("times shuffled", shuffled, increase), Damage("time again", same_time, increase),
        Damage("no column of time", no_time, r"no column of time"),
        Damage("cell is a word", word, r"is not a number"),
        Damage("fewer cells in a row", fewer_cells, r"cells? where"),
        Damage("no rows", nothing, r"no rows"),
        Damage("row far too long", long_row, r"longer than"),
        cut(what, early), spliced(what), beheaded(what),
    ]  # fmt: skip


def _moved(what: str, name: str, change: Callable[[Columns, Random], None], told: str | None) -> Damage:
    return Damage(name, lambda trial, rng: change(_of(trial, what), rng), told)


def _scaled(factor: float, part: str = "") -> Callable[[Columns, Random], None]:
    """All columns, or those whose names have a part, in another unit."""

    def change(columns: Columns, rng: Random) -> None:
        chosen = [k for k, name in enumerate(columns.names) if part in name]
        columns.values[:, chosen] *= factor

    return change


def _timed(factor: float, shift: float) -> Callable[[Columns, Random], None]:
    def change(columns: Columns, rng: Random) -> None:
        columns.times = factor * columns.times + shift

    return change


def _said(key: str, word: str | None) -> Callable[[Columns, Random], None]:
    def change(columns: Columns, rng: Random) -> None:
        columns.head.pop(key, None)
        if word is not None:
            columns.head[key] = word

    return change


def _without(first: float, last: float) -> Callable[[Columns, Random], None]:
    def change(columns: Columns, rng: Random) -> None:
        n = len(columns.times)
        columns.keep([k for k in range(n) if not first * n < k < last * n])

    return change


def _thinned(every: int) -> Callable[[Columns, Random], None]:
    return lambda columns, rng: columns.keep(slice(None, None, every))


def _radians(columns: Columns, rng: Random) -> None:
    turned = [k for k, name in enumerate(columns.names) if not name.endswith(("_tx", "_ty", "_tz"))]
    columns.values[:, turned] = np.radians(columns.values[:, turned])


def _swapped_angles(columns: Columns, rng: Random) -> None:
    """A knee's values under the name of a hip, the other way round."""
    for side in ("", "_r", "_l"):
        knee, hip = f"knee_angle{side}", f"hip_flexion{side}"
        if knee in columns.names and hip in columns.names:
            a, b = columns.names.index(knee), columns.names.index(hip)
            columns.names[a], columns.names[b] = hip, knee


def _other_sign(columns: Columns, rng: Random) -> None:
    chosen = [k for k, name in enumerate(columns.names) if "knee_angle" in name]
    columns.values[:, chosen] = -columns.values[:, chosen] + 20.0


def _spike(columns: Columns, rng: Random) -> None:
    k = next(k for k, name in enumerate(columns.names) if "hip_flexion" in name)
    columns.values[rng.randrange(3, len(columns.times) - 3), k] += 70.0


def _shuffled_rows(columns: Columns, rng: Random) -> None:
    order = list(range(len(columns.times)))
    rng.shuffle(order)
    columns.values = columns.values[order]


def _one_side_in_radians(columns: Columns, rng: Random) -> None:
    side = rng.choice(["_r", "_l"])
    columns.values[:, [name == f"knee_angle{side}" for name in columns.names]] *= np.pi / 180.0


def _lacking(columns: Columns, rng: Random) -> None:
    keep = [k for k, name in enumerate(columns.names) if not name.startswith("pelvis")]
    columns.names, columns.values = [columns.names[k] for k in keep], columns.values[:, keep]


def _renamed(columns: Columns, rng: Random) -> None:
    columns.names = [f"x{k}" for k in range(len(columns.names))]


def _upside_down(columns: Columns, rng: Random) -> None:
    chosen = [k for k, name in enumerate(columns.names) if name.endswith("_ty")]
    columns.values[:, chosen] *= -1.0


COORDINATES: list[Damage] = [
    *usual("coordinates"),
    _moved("coordinates", "unit not told", _said("inDegrees", None), r"does not tell the unit"),
    _moved("coordinates", "said to be radians", _said("inDegrees", "no"), r"beyond eight turns|degrees"),
    _moved("coordinates", "radians said to be degrees", _radians, r"radians"),
    _moved("coordinates", "knees and hips swapped", _swapped_angles, r"leaves its range"),
    _moved("coordinates", "other sign", _other_sign, r"leaves its range"),
    _moved("coordinates", "spike", _spike, r"jump of"),
    _moved("coordinates", "rows shuffled", _shuffled_rows, r"to and fro"),
    _moved("coordinates", "one knee in radians", _one_side_in_radians, r"of the other side"),
    _moved("coordinates", "no pelvis", _lacking, r"lacks|the motion has"),
    _moved("coordinates", "other names", _renamed, r"no column has the name"),
    _moved("coordinates", "upside down", _upside_down, r"far from|below"),
    _moved("coordinates", "millimetres", _scaled(1000.0, "_ty"), r"mm|far from"),
    _moved("coordinates", "milliseconds", _timed(1000.0, 0.0), r"reach from|apart"),
    _moved("coordinates", "missing frames", _without(0.35, 0.75), r"no frames? between"),
    _moved("coordinates", "nRows", _said("nRows", "7"), r"promises nRows"),
    _moved("coordinates", "nColumns", _said("nColumns", "99999999999"), r"promises nColumns"),
]


def _without_torques(columns: Columns, rng: Random) -> None:
    keep = [k for k, name in enumerate(columns.names) if not name.endswith("_torque_x")]
    columns.names, columns.values = [columns.names[k] for k in keep], columns.values[:, keep]


def _forces(change: Callable[[np.ndarray], np.ndarray], part: str) -> Callable[[Columns, Random], None]:
    def apply(columns: Columns, rng: Random) -> None:
        for start in {name[:-1] for name in columns.names if part in name}:
            at = [columns.names.index(f"{start}{axis}") for axis in "xyz"]
            columns.values[:, at] = change(columns.values[:, at])

    return apply


def _z_up(columns: Columns, rng: Random) -> None:
    for part in ("force_v", "force_p", "torque"):
        _forces(lambda x: x[:, [0, 2, 1]] * (1.0, -1.0, 1.0), part)(columns, rng)


def _swapped_feet(trial: Trial, rng: Random) -> None:
    bodies = [plate[0] for plate in trial.plates]
    trial.plates = [(body, *plate[1:]) for body, plate in zip(bodies[::-1], trial.plates, strict=True)]


def _one_plate(trial: Trial, rng: Random) -> None:
    trial.plates = trial.plates[:1]


def _swapped_forces(trial: Trial, rng: Random) -> None:
    """Forces of one plate at the points of the other one, where there are two."""
    if len(trial.plates) < 2:
        return
    values = trial.loads.values
    mine, other = ([trial.loads.names.index(f"{plate[1]}{axis}") for axis in "xyz"] for plate in trial.plates[:2])
    values[:, mine], values[:, other] = values[:, other].copy(), values[:, mine].copy()


def _ahead(columns: Columns, rng: Random) -> None:
    columns.values[:, [name.endswith("force_px") for name in columns.names]] += 0.25


def _offset(columns: Columns, rng: Random) -> None:
    columns.values[:, [name.endswith("force_vy") for name in columns.names]] += rng.uniform(50.0, 100.0)


def _same_name(trial: Trial, rng: Random) -> None:
    names = [f'name="on_{plate[0]}"'.encode() for plate in trial.plates]
    trial.edit("described", lambda data: data.replace(names[-1], names[0]))


def _described(name: str, old: bytes, new: bytes, told: str) -> Damage:
    return Damage(name, lambda trial, rng: trial.edit("described", lambda data: data.replace(old, new, 1)), told)


CARRY = r"weight|points? down"
LOADS: list[Damage] = [
    *usual("loads"),
    _moved("loads", "another time", _timed(1.0, 30.0), r"reach from"),
    _moved("loads", "half another time", _timed(1.0, 0.4), r"reach from"),
    _moved("loads", "milliseconds", _timed(1000.0, 0.0), r"reach from"),
    _moved("loads", "every fifth of a second", _thinned(60), r"apart|reach"),
    _moved("loads", "missing frames", _without(0.3, 0.8), r"no frames? between"),
    _moved("loads", "kilonewtons", _scaled(0.001, "force_v"), CARRY),
    _moved("loads", "points in mm", _scaled(1000.0, "force_p"), r"far from"),
    _moved("loads", "upside down", _forces(lambda x: x * (1.0, -1.0, 1.0), "force_v"), CARRY),
    _moved("loads", "of the feet on the ground", _forces(lambda x: -x, "force_v"), CARRY),
    _moved("loads", "z up", _z_up, CARRY),
    _moved("loads", "no forces", _scaled(0.0, "force_v"), CARRY),
    _moved("loads", "points at the origin", _scaled(0.0, "force_p"), r"far from|nearer"),
    _moved("loads", "no torque about x", _without_torques, r"no column"),
    _moved("loads", "nRows", _said("nRows", "1e9"), r"is not a count"),
    _moved("loads", "nRows", _said("nRows", "123456789"), r"promises"),
    _moved("loads", "moments in N mm", _scaled(1000.0, "torque"), r"at an arm of"),
    _moved("loads", "forwards of the other sign", _forces(lambda x: x * (-1.0, 1.0, 1.0), "force_v"), r"push forwards"),
    _moved("loads", "points a foot ahead", _ahead, r"far from"),
    _moved("loads", "an offset", _offset, r"swings|weight"),
    Damage("forces swapped", _swapped_forces, r"swings"),
    Damage("two forces of one name", _same_name, r"two forces are called"),
    Damage("feet swapped", _swapped_feet, r"nearer to"),
    Damage("one plate of two", _one_plate, CARRY),
    _described("another body", b">calcn", b">hoof", r"does not have"),
    _described("columns that are not there", b"force_v<", b"kraft_v<", r"no column"),
    _described("no table", b"loads.mot", b"other.mot", r"no such file"),
    _described("table elsewhere", b"loads.mot", b"../../secret.mot", r"no such file"),
    _described("axes of no body", b"<force_expressed_in_body>ground", b"<force_expressed_in_body>hoof",
               r"does not have"),
    _described("other elements", b"ExternalForce", b"Ballista", r"."),
    cut("described", r"."), spliced("described"), beheaded("described"),
]  # fmt: skip


def _raw(columns: Columns, rng: Random) -> None:
    columns.values = columns.values - 0.3


def _half_unknown(columns: Columns, rng: Random) -> None:
    columns.names = [name if k % 2 else f"channel {k}" for k, name in enumerate(columns.names)]


def _dead(columns: Columns, rng: Random) -> None:
    columns.values[:, rng.randrange(len(columns.names))] = 0.0


def _saturated(columns: Columns, rng: Random) -> None:
    columns.values[:, rng.randrange(len(columns.names))] = 1.0


def _faster(columns: Columns, rng: Random) -> None:
    at = np.linspace(columns.times[0], columns.times[-1], 10 * len(columns.times) - 7)
    columns.values = np.stack([np.interp(at, columns.times, one) for one in columns.values.T], axis=1)
    columns.times = at


EMG: list[Damage] = [
    *usual("emg"),
    _moved("emg", "raw, not rectified", _raw, r"from 0 to 1"),
    _moved("emg", "microvolts", _scaled(300.0), r"from 0 to 1"),
    _moved("emg", "ten times the rate", _faster, None),
    _moved("emg", "another rate", _thinned(2), None),
    _moved("emg", "a tenth of the rate", _thinned(20), r"apart"),
    _moved("emg", "another time", _timed(1.0, 20.0), r"reaches from"),
    _moved("emg", "samples for seconds", _timed(200.0, 0.0), r"reaches from"),
    _moved("emg", "missing frames", _without(0.3, 0.8), r"no frames? between"),
    _moved("emg", "dead channel", _dead, r"zero throughout"),
    _moved("emg", "saturated channel", _saturated, r"never changes"),
    _moved("emg", "two samples", lambda columns, rng: columns.keep([0, -1]), r"apart"),
    _moved("emg", "other names", _renamed, r"no column has the name"),
    _moved("emg", "half of other names", _half_unknown, r"no muscle"),
]
