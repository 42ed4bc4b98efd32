"""Positions of markers from files: .trc, .c3d, tables with a column a coordinate, Vicon's, and MLSE's .json."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.synergy.c3d import read_points
from warpmuscle.synergy.columns import TIMES, plain_name
from warpmuscle.synergy.tables import read_table
from warpmuscle.synergy.vicon import TRAJECTORIES, is_export, vicon_block

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}  # m
TRC_HEAD = 5  # lines
_COORDINATE = re.compile(rf"(.+?)[\s_.:-]+([xyz])(?:[\s_]*[\[(]?\s*({'|'.join(UNITS)})\s*[\])]?)?", re.IGNORECASE)


@dataclass(frozen=True)
class Markers:
    """Positions of K markers at T times; NaN where one was not seen."""

    path: Path
    time: Floats  # (T,) s
    names: tuple[str, ...]
    position: Floats  # (T, K, 3) m, in the axes of the file
    begin: float = 0.0  # s, what the file has as the time of the first frame

    def of(self, name: str) -> Floats:
        """Positions (T, 3) of a marker, letter case aside, or the mean of several whose names + joins.

        Raises:
            SignalError: no marker has that name.
        """
        known = {own.lower(): k for k, own in enumerate(self.names)}
        parts = []
        for one in name.split("+"):
            if one.strip().lower() not in known:
                listed = ", ".join(self.names[:40]) + (" ..." if len(self.names) > 40 else "")
                raise SignalError(f"no marker {one.strip()!r}; it has {listed}", file=self.path)
            parts.append(self.position[:, known[one.strip().lower()]])
        return np.asarray(np.mean(parts, axis=0))


def read_markers(path: str | Path, unit: str | None = None) -> Markers:
    """The markers of a file.

    Args:
        unit: of its positions, one of `UNITS`; by default what the file says, or feet in .json, else m.

    Raises:
        SignalError: the file cannot be read, is of another kind, or holds no markers.
    """
    path = Path(path)
    if unit is not None and unit not in UNITS:
        raise SignalError(f"unit {unit!r} is not known; use {', '.join(UNITS)}")
    readers = {".trc": _trc, ".c3d": _c3d, ".json": _json}
    time, names, position, own = readers.get(path.suffix.lower(), _table)(path)
    if len(time) < 2 or not names:
        raise SignalError(
            f"holds {number_of(len(time), 'frame')} of {number_of(len(names), 'marker')}; there must be two frames",
            file=path,
        )
    wrong_time = ~np.isfinite(time)
    wrong_time[1:] |= ~(np.diff(time) > 0.0)
    if wrong_time.any():
        raise SignalError(
            f"times must be numbers that increase; that of frame {int(np.argmax(wrong_time)) + 1} does not", file=path
        )
    if len(wrong := np.argwhere(np.isinf(position))):
        frame, marker, _ = wrong[0]
        raise SignalError(f"marker {names[marker]!r} is infinitely far away in frame {frame + 1}", file=path)
    lost = (position == 0.0).all(axis=2)  # as many programs write what a camera did not see
    position = np.where((lost & ~lost.all(axis=0))[..., None], np.nan, position)
    return Markers(path, time - time[0], names, position * UNITS[unit or own], float(time[0]))


Read = tuple[Floats, tuple[str, ...], Floats, str]  # times, names, positions (T, K, 3), and their unit


def _trc(path: Path) -> Read:
    """Track row column, as OpenSim and motion capture write it: tabs, five lines of head."""
    lines = _text(path).splitlines()
    if len(lines) <= TRC_HEAD or "Units" not in lines[1].split("\t"):
        raise SignalError("has no head as .trc files have, with `Units` in its second line", file=path)
    values = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=False))
    unit = values["Units"].strip() if "Units" in values else "mm"
    if unit not in UNITS:
        raise SignalError(f"unit {unit!r} is not known; use {', '.join(UNITS)}", file=path, line=3)
    names = _once(tuple(cell.strip() for cell in lines[3].split("\t")[2:] if cell.strip()), values.get("NumMarkers"))
    _check_promised(path, values, "NumMarkers", len(names))
    head = TRC_HEAD - (lines[TRC_HEAD - 1].partition("\t")[0].strip().isdigit())  # some leave out the row of X1, Y1, Z1
    check_size("samples", 3 * len(names) * len(lines), lambda text: SignalError(text, file=path))
    rows, written = [], []
    for number, line in enumerate(lines[head:], start=head + 1):
        if not line.strip():
            continue
        if "\t" not in line:
            raise SignalError("there are no tabs between the columns of this row", file=path, line=number)
        cells = line.rstrip("\r\n").split("\t")[1 : 2 + 3 * len(names)]
        cells += [""] * (1 + 3 * len(names) - len(cells))
        try:
            rows.append([float(cell) if cell.strip() else np.nan for cell in cells])
        except ValueError:
            raise SignalError("holds a cell that is not a number", file=path, line=number) from None
        written.append(cells[0].strip())
    _check_promised(path, values, "NumFrames", len(rows))
    table = np.array(rows, dtype=np.float64).reshape(-1, 1 + 3 * len(names))
    time = _even(table[:, 0], written, values.get("DataRate", ""))
    return time, names, _positions(table[:, 1:], path), unit


def _once(names: tuple[str, ...], promised: str | None) -> tuple[str, ...]:
    """Names of markers, which some programs write once a column: as `RASI_x`, `RASI_y`, `RASI_z`."""
    stems = tuple(name[:-1].rstrip("_-. ") for name in names[::3])
    axes = [(name[:-1].rstrip("_-. "), name[-1:].lower()) for name in names]
    each = [(stem, axis) for stem in stems for axis in "xyz"]
    return stems if all(stems) and axes == each and (promised or "").strip() == str(len(stems)) else names


def _check_promised(path: Path, head: Mapping[str, str], key: str, count: int) -> None:
    """Raise SignalError if a head promises another number of frames or markers, as that of a truncated file does."""
    word = head.get(key, "").strip()
    if word and word != str(count):
        raise SignalError(
            f"the head promises {key}={word[:20]}, but there are {count}: the file is cut off, or write {count}",
            file=path, line=3,
        )  # fmt: skip


def _even(time: Floats, written: list[str], rate: str) -> Floats:
    """Times at the rate that the head tells, if those in the file are these, rounded to a few digits."""
    try:
        step = 1.0 / float(rate)
    except (ValueError, ZeroDivisionError):
        return time
    decimals = max((len(text.partition(".")[2].rstrip("0")) for text in written), default=0)
    if not np.isfinite(step) or not len(time) or any("e" in text.lower() for text in written):
        return time
    even = time[0] + step * np.arange(len(time))
    for shift in (0.0, 0.5 * (np.max(time - even) + np.min(time - even))):  # the first one may be rounded, too
        if np.abs(time - even - shift).max() <= 0.5001 * 10.0**-decimals:
            return np.asarray(even + shift)
    return time


def _table(path: Path) -> Read:
    """A table with a column of time and of each marker's coordinates: NAME_x, `NAME.X`, `NAME x (mm)`."""
    if is_export(path):
        return _vicon(path)
    table = read_table(path)
    plain = [plain_name(name) for name in table.names]
    time = next((plain.index(name) for name in TIMES if name in plain), None)
    if time is None:
        raise SignalError("no column of time; name one `time_s`", file=path)
    places: dict[str, dict[str, int]] = {}
    units = set()
    for column, heading in enumerate(table.names):
        if found := _COORDINATE.fullmatch(heading.strip()):
            places.setdefault(found[1], {})[found[2].lower()] = column
            units.add((found[3] or "").lower())
    names = tuple(name for name, columns in places.items() if len(columns) == len("xyz"))
    if not names:
        raise SignalError("no markers: each has columns NAME_x, NAME_y and NAME_z", file=path)
    if len(units) > 1:
        raise SignalError("some headings of coordinates name another unit than others, or none", file=path)
    values = table.columns([time, *(places[name][axis] for name in names for axis in "xyz")], gaps=True)
    return TIMES[plain[time]] * values[:, 0], names, _positions(values[:, 1:], path), units.pop() or "m"


def _positions(columns: Floats, path: Path) -> Floats:
    """Columns (F, 3 K) as positions (F, K, 3); SignalError if there are no frames, or no markers."""
    if not columns.size:
        raise SignalError("has no frames" if columns.shape[1] else "has no markers", file=path)
    return columns.reshape(len(columns), -1, 3)


def _vicon(path: Path) -> Read:
    """The trajectories of Vicon's table; `Anna:RSHO` is called RSHO, unless two subjects have one."""
    block = vicon_block(path, TRAJECTORIES)
    owners = list(dict.fromkeys(block.owners))
    short = [name.rpartition(":")[2] for name in owners]
    headings = zip(block.owners, block.headings, strict=True)
    places = {(owner, axis.upper()): k for k, (owner, axis) in enumerate(headings)}
    whole = [k for k, owner in enumerate(owners) if all((owner, axis) in places for axis in "XYZ")]
    if not whole:
        raise SignalError("no markers: each has columns X, Y and Z", file=path)
    unit = next((unit for unit in block.units if unit), "mm")
    if unit not in UNITS or any(other not in ("", unit) for other in block.units):
        raise SignalError(f"units of positions must be one of {', '.join(UNITS)}, not {', '.join(set(block.units))}",
                          file=path)  # fmt: skip
    values = block.values[:, [places[owners[k], axis] for k in whole for axis in "XYZ"]]
    names = tuple(short[k] if short.count(short[k]) == 1 else owners[k] for k in whole)
    return np.arange(len(values)) / block.rate, names, _positions(values, path), unit


def _json(path: Path) -> Read:
    """MLSE's open data: `tracking`, a list of frames with `time`, ms, and `data.player`, points in feet."""
    try:
        content = json.loads(_text(path))
    except (ValueError, RecursionError):
        raise SignalError("is not JSON", file=path) from None
    frames = content.get("tracking") if isinstance(content, Mapping) else None
    if not isinstance(frames, list) or not frames:
        raise SignalError("has no list `tracking` of frames", file=path)
    players = [_player(path, number, frame) for number, frame in enumerate(frames)]
    names = tuple(players[0])
    position = np.full((len(frames), len(names), 3), np.nan)
    for row, player in enumerate(players):
        for column, name in enumerate(names):
            if name in player:
                position[row, column] = _point(path, row, name, player[name])
    try:
        time = np.array([float(frame["time"]) for frame in frames]) / 1000.0
    except (KeyError, TypeError, ValueError):
        raise SignalError("a frame has no number `time`", file=path) from None
    return np.linspace(time[0], time[-1], len(time)), names, position, "ft"  # their times are rounded to ms


def _player(path: Path, number: int, frame: Any) -> Mapping[str, Any]:
    data = frame.get("data") if isinstance(frame, Mapping) else None
    player = data.get("player") if isinstance(data, Mapping) else None
    if not isinstance(player, Mapping):
        raise SignalError(f"frame {number} has no `data.player`", file=path)
    return player


def _point(path: Path, row: int, name: str, value: Any) -> Floats:
    try:
        point = np.array([np.nan if x is None else float(x) for x in value], dtype=np.float64)
    except (TypeError, ValueError):
        point = np.zeros(0)
    if point.shape != (3,):
        raise SignalError(f"frame {row}: {name} is not three numbers", file=path)
    return point


def _c3d(path: Path) -> Read:
    names, rate, values, unit = read_points(path)
    if unit not in UNITS:
        raise SignalError(f"unit {unit!r} of its points is not known; use {', '.join(UNITS)}", file=path)
    return np.arange(len(values)) / rate, names, values, unit


def _text(path: Path) -> str:
    try:
        return read_file(path, "table").decode("utf-8-sig")
    except FileNotFoundError:
        raise SignalError("there is no such file", file=path) from None
    except (OSError, ValueError) as error:
        raise SignalError("is not a text file" if isinstance(error, UnicodeError) else unreadable(error),
                          file=path) from None  # fmt: skip
