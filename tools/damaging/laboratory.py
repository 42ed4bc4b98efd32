"""A C3D as a laboratory records it, z up and in mm, with markers, two force plates and raw EMG; and its damages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from damaging.c3d_file import plate_channels, write_c3d
from damaging.damage import Damage, cut
from damaging.markers import (
    FEW,
    MISS,
    frozen,
    gap_of_all,
    gap_of_one,
    label_twice,
    of_a_subject,
    parameter_bytes,
    shifted_labels,
    spike,
    swapped_half_way,
    swapped_labels,
    turned,
)
from damaging.trial import Trial

ROOM = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # its axes in ground axes: z up, y forward
SAMPLES = 12  # of a channel in a frame
SIZE = (3000.0, 600.0)  # mm, half of a plate's edges
ORIGINS = {2: (4.0, -3.0, -41.0), 3: (2000.0, 400.0, -54.0)}
KINDS = (2, 3)
EMG = ("EMG 1", "EMG 2")


@dataclass
class Laboratory:
    """What a C3D has beside markers, and what is changed of it: parameters, then analog values."""

    samples: int = SAMPLES
    units: dict[str, str] = field(default_factory=dict)  # by what channels have in the file
    parameters: list[Callable[[dict[str, Any]], None]] = field(default_factory=list)
    analogs: list[Callable[[Any, list[str]], Any]] = field(default_factory=list)
    names: list[Callable[[list[str]], list[str]]] = field(default_factory=list)
    screen: tuple[str, str] = ("+X", "+Z")
    of_foot: tuple[bool, bool] = (False, True)  # whether plates tell the force of the foot


def write_laboratory(trial: Trial, own: Laboratory, path: Path) -> None:
    """Write the trial as a C3D; loads that are changed change the channels of its plates."""
    frames = len(trial.marker_times)
    rate = float(np.round((frames - 1) / np.ptp(trial.marker_times), 6))
    times = trial.marker_times[0] + np.arange(frames * own.samples) / (rate * own.samples)
    columns, corners = [], []
    for (_, *starts), kind, of_foot in zip(trial.plates, KINDS, own.of_foot, strict=False):
        force, point, moment = (
            np.stack([np.interp(times, trial.loads.times, trial.loads.values[:, trial.loads.names.index(start + axis)])
                      for axis in "xyz"], axis=1) @ ROOM.T * factor
            for start, factor in zip(starts, (1.0, 1000.0, 1000.0), strict=True)
        )  # fmt: skip
        ground = np.array([[x * SIZE[0], 0.0, z * SIZE[1]] for x, z in ((1, 1), (-1, 1), (-1, -1), (1, -1))])
        corners.append(ground @ ROOM.T)
        columns.append(plate_channels(kind, corners[-1], np.array(ORIGINS[kind]), force, point, moment, of_foot))
    noise = np.random.default_rng(5).normal(size=(len(times), len(EMG)))
    columns.append(1e-4 * noise * (1.2 + np.sin(8.0 * times)[:, None]))
    names = [f"Plate{k + 1}.{n + 1}" for k in range(len(corners)) for n in range(columns[k].shape[1])] + list(EMG)
    units = [own.units.get(unit, unit) for unit in (*["N"] * 3, *["Nmm"] * 3, *["N"] * 8, "V", "V")]
    first = np.cumsum([1, *(one.shape[1] for one in columns)])
    channels = [np.pad(first[k] + np.arange(columns[k].shape[1]), (0, 8 - columns[k].shape[1])) for k in (0, 1)]
    plates: dict[str, Any] = {
        "USED": 2, "TYPE": np.array(KINDS), "ZERO": np.array([1, 0]),
        "CORNERS": np.stack([one.T for one in corners], axis=2),
        "ORIGIN": np.stack([ORIGINS[kind] for kind in KINDS], axis=1), "CHANNEL": np.stack(channels, axis=1),
    }  # fmt: skip
    for change in own.parameters:
        change(plates)
    analogs = np.concatenate(columns, axis=1)
    for change in own.analogs:
        analogs = change(analogs, names)
    for change in own.names:
        names = change(names)
    write_c3d(
        path, trial.positions @ ROOM.T, trial.marker_names, rate, analogs, names, units,
        {"FORCE_PLATFORM": plates, "POINT": {"X_SCREEN": own.screen[0], "Y_SCREEN": own.screen[1]}}, trial.unit,
    )  # fmt: skip


def _parameter(name: str, change: Callable[[dict[str, Any]], None], told: str | None) -> Damage:
    return Damage(name, lambda trial, rng: trial.laboratory().parameters.append(change), told)


def _set(key: str, value: Any, told: str | None, name: str = "") -> Damage:
    """A parameter of FORCE_PLATFORM that is another; none if it is None."""

    def change(plates: dict[str, Any]) -> None:
        if value is None:
            plates.pop(key, None)
        else:
            plates[key] = value(plates[key]) if callable(value) else value

    return _parameter(f"{key} {name or value}", change, told)


def _analog(name: str, change: Callable[[Any, Random], Any], told: str | None, part: str = "Plate") -> Damage:
    """Channels whose names begin with a text are others."""

    def damage(trial: Trial, rng: Random) -> None:
        def apply(values: Any, names: list[str]) -> Any:
            chosen = [k for k, own in enumerate(names) if own.startswith(part)]
            values[:, chosen] = change(values[:, chosen], rng)
            return values

        trial.laboratory().analogs.append(apply)

    return Damage(name, damage, told)


def _units(name: str, units: dict[str, str], told: str | None) -> Damage:
    return Damage(name, lambda trial, rng: trial.laboratory().units.update(units), told)


def _named(name: str, change: Callable[[list[str]], list[str]], told: str | None) -> Damage:
    return Damage(name, lambda trial, rng: trial.laboratory().names.append(change), told)


def _one_cell(value: float) -> Callable[[Any, Random], Any]:
    def change(values: Any, rng: Random) -> Any:
        values[rng.randrange(len(values)), rng.randrange(values.shape[1])] = value
        return values

    return change


def _spike_of_force(values: Any, rng: Random) -> Any:
    values[rng.randrange(len(values)), 2] = rng.choice([1e12, -1e15])
    return values


def _screen(trial: Trial, rng: Random) -> None:
    trial.laboratory().screen = rng.choice([("+X", "+Y"), ("", ""), ("+Z", "+Z"), ("up", "down"), ("-Z", "-X")])


def _reacting(trial: Trial, rng: Random) -> None:
    trial.laboratory().of_foot = rng.choice([(True, True), (False, False), (True, False)])


def _samples(count: int) -> Callable[[Trial, Random], None]:
    def change(trial: Trial, rng: Random) -> None:
        trial.laboratory().samples = count

    return change


def _shuffled_channels(plates: dict[str, Any]) -> None:
    plates["CHANNEL"][:6, 0] = plates["CHANNEL"][[2, 0, 1, 3, 4, 5], 0]


def _swapped_plates(plates: dict[str, Any]) -> None:
    for key in ("TYPE", "CORNERS", "ORIGIN", "CHANNEL"):
        plates[key] = plates[key][..., ::-1]


def _moved(plates: dict[str, Any]) -> None:
    """Both plates, so that up is found as before, 4 m to the side."""
    plates["CORNERS"] = plates["CORNERS"] + np.array([4000.0, 0.0, 0.0])[:, None, None]


def _lower(plates: dict[str, Any]) -> None:
    plates["CORNERS"] = plates["CORNERS"] - np.array([0.0, 0.0, 700.0])[:, None, None]


def _wall(plates: dict[str, Any]) -> None:
    plates["CORNERS"] = plates["CORNERS"][[0, 2, 1]]


def _bytes_of_plates(trial: Trial, rng: Random) -> None:
    """Random bytes where the parameters of plates are."""

    def change(data: bytes) -> bytes:
        content, at = bytearray(data), data.index(b"FORCE_PLATFORM")
        for _ in range(rng.choice([1, 3, 12])):
            content[at + 14 + rng.randrange(400)] = rng.randrange(256)
        return bytes(content)

    trial.edit("c3d", change)


ABSENT = r"channel .* is not there"
LOAD = r"weight|swings|far from|nearer to|push forwards|pull the body down|beyond its edge|at an arm"
LABORATORY: list[Damage] = [
    _set("TYPE", np.array([5, 2]), r"of TYPE 5"), _set("TYPE", np.array([2, 21]), r"of TYPE 21"),
    _set("TYPE", np.array([2, -3]), r"of TYPE -3"),
    _set("TYPE", np.array([4, 3]), r"CAL_MATRIX"), _set("TYPE", np.array([2]), r"TYPE is of 1"),
    _set("TYPE", None, r"TYPE is of 0"), _set("TYPE", np.array([2, 2]), LOAD),
    _set("USED", 5, r"USED says 5"), _set("USED", 0, r"no force plates"), _set("USED", -1, r"no force plates"),
    _set("USED", None, r"no force plates"), _set("USED", 1, LOAD),
    _set("CHANNEL", lambda x: x + 90, ABSENT), _set("CHANNEL", lambda x: x * 0, ABSENT),
    _set("CHANNEL", lambda x: x[:4], r"needs 6 channels"), _set("CHANNEL", None, r"CHANNEL is of 0"),
    _set("CHANNEL", lambda x: x[:, :1], r"CHANNEL is of 1"), _set("CHANNEL", lambda x: -x, ABSENT),
    _parameter("channels of one plate shuffled", _shuffled_channels, LOAD),
    _parameter("the two plates in the other order", _swapped_plates, None),
    _set("CORNERS", lambda x: 0.0 * x, r"rectangle"), _set("CORNERS", lambda x: x * np.nan, r"finite numbers"),
    _set("CORNERS", None, r"CORNERS is of 0"), _set("CORNERS", lambda x: x[:, :3], r"CORNERS is of 1"),
    _set("CORNERS", lambda x: x / 1000.0, LOAD, "in m"),
    _set("CORNERS", lambda x: x[:, ::-1], LOAD, "the other way round"),
    _set("CORNERS", lambda x: np.roll(x, 2, axis=1), LOAD, "from the third on"),
    _parameter("plates 4 m aside", _moved, LOAD), _parameter("plates below the floor", _lower, r"far from|moment"),
    _parameter("plates on the wall", _wall, r"upright|" + LOAD),
    _set("ORIGIN", None, r"ORIGIN is of 0"), _set("ORIGIN", lambda x: x * (1.0, 1.0, -1.0)[0], None, "as it is"),
    _set("ORIGIN", lambda x: x * np.array([[1.0], [1.0], [-1.0]]), None, "without its sign"),
    _set("ORIGIN", lambda x: x * np.inf, r"finite numbers"), _set("ORIGIN", lambda x: 50.0 * x, LOAD, "far away"),
    _set("ZERO", np.array([20, 30]), r"none is taken off"), _set("ZERO", np.array([30, 2]), None),
    _set("ZERO", np.array([1, 9999]), None), _set("ZERO", None, None),
    _units("moments said to be in N m", {"Nmm": "Nm"}, r"beyond its edge"),
    _units("units of volts", {"N": "V", "Nmm": "V"}, r"taken for N"),
    _units("kilonewtons", {"N": "kN"}, LOAD), _units("no units", {"N": "", "Nmm": "", "V": ""}, None),
    _units("pounds", {"N": "lbf"}, r"taken for N"), _units("N.mm", {"Nmm": "N.mm"}, None),
    _analog("not a number", _one_cell(np.nan), r"not a finite number|NaN|finite"),
    _analog("infinite", _one_cell(np.inf), r"not a finite number|finite"),
    _analog("a force beyond measure", _spike_of_force, r"N in frame|weight|beyond"),
    _analog("dead plates", lambda x, rng: 0.0 * x, r"weight"),
    _analog("an offset", lambda x, rng: x + rng.uniform(40.0, 90.0), LOAD),
    _analog("backwards in time", lambda x, rng: x[::-1], LOAD),
    _analog("another trial", lambda x, rng: np.roll(x, len(x) // 3, axis=0), LOAD),
    _analog("not amplified", lambda x, rng: 0.01 * x, r"weight"),
    _analog("saturated", lambda x, rng: np.clip(x, -150.0, 150.0), LOAD),
    Damage("reactions or actions", _reacting, None), Damage("the screen says others", _screen, None),
    _named("another name of a channel", lambda names: [*names[:-2], "Voltage.1", names[-1]], r"EMG 1"),
    _named("two channels of one name", lambda names: [*names[:-1], names[-2]], r"EMG|name"),
    _analog("a dead electrode", lambda x, rng: 0.0 * x, r"is 0 throughout", "EMG"),
    _analog("a saturated electrode", lambda x, rng: 0.0 * x + 1.0, r"is 1 throughout", "EMG"),
    _analog("EMG is no number", _one_cell(np.nan), r"finite|nan", "EMG"),
    _analog("EMG is rectified", lambda x, rng: np.abs(x), r"", "EMG"),
    Damage("EMG as fast as markers", _samples(1), r""), Damage("another rate", _samples(7), None),
    Damage("gap of one", gap_of_one, None), Damage("gap of all", gap_of_all, r"no marker is seen"),
    Damage("two labels swapped", swapped_labels, MISS), Damage("two labels swapped half-way", swapped_half_way, MISS),
    Damage("labels shifted by three", shifted_labels, MISS), Damage("labels of a subject", of_a_subject, FEW),
    Damage("label twice", label_twice, r"two markers are called"), Damage("frozen marker", frozen, MISS),
    Damage("spike", spike, MISS), turned("mirrored", (0, 1, 2), (1, 1, -1)),
    Damage("bytes of parameters", parameter_bytes, r""), Damage("bytes of plates", _bytes_of_plates, r""),
    cut("c3d", r"C3D|truncated|empty"),
]  # fmt: skip
