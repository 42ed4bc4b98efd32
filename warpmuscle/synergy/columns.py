"""Named columns of one recorded motion, by whatever unit their names tell: times, angles and places."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.core.plain_text import readable
from warpmuscle.synergy.tables import Table

TIMES = {"time": 1.0, "time_s": 1.0, "t": 1.0, "t_s": 1.0, "time_ms": 1e-3, "t_ms": 1e-3}  # s
LENGTHS = {"_m": 1.0, "": 1.0, "_mm": 1e-3, "_cm": 1e-2}  # m
ANGLES = ("_deg", "_rad", "")
LONGEST_GAP = 0.06  # s between the samples on both sides of one, beyond that between any two
WORDS = {"degrees": "deg", "degree": "deg", "°": "deg", "º": "deg", "radians": "rad", "radian": "rad",
         "seconds": "s", "second": "s", "sec": "s", "meters": "m", "metres": "m"}  # fmt: skip
_IN_BRACKETS = re.compile(r"\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")
_ROUNDED = re.compile(r"-?\d+(?:\.(\d*))?\s*$")
SELDOM = 0.1  # part of all steps
MOST_NAMED = 12  # columns in an error


def plain_name(heading: str) -> str:
    """A heading such as `Elbow flexion [deg]` as the name of a column, `elbow_flexion_deg`."""
    found = _IN_BRACKETS.search(heading)
    parts = [heading[: found.start()], found[1]] if found and found[1] else [heading]
    words = re.split(r"[\s_\-./]+", "_".join(parts).strip().lower())
    return "_".join(word for word in [*words[:-1], WORDS.get(words[-1], words[-1])] if word)


def with_units(names: Sequence[str], units: Sequence[str] = ANGLES) -> list[str]:
    """Columns that may hold one of these, with or without the unit in their names."""
    return [f"{name}{unit}" for name in names for unit in units]


@dataclass
class Columns:
    """Columns of one motion, read when they are asked for.

    Attributes:
        bridged: samples that lacked a value, which a spline through the others gives, counted in all columns.
    """

    path: Path
    motion: str
    names: list[str]
    table: Table | None = None
    arrays: dict[str, Floats] = field(default_factory=dict)
    bridged: int = 0

    @classmethod
    def of_table(cls, table: Table) -> Columns:
        """Those of a file with one motion, which is called as the file is."""
        return cls(table.path, readable(table.path.stem), [plain_name(name) for name in table.names], table)

    def only(self, what: str, names: Sequence[str]) -> str | None:
        """The one of these columns that there is, None if there is none."""
        present = [name for name in self.names if name in names]
        if len(present) > 1:
            raise self.error(f"more than one column with {what}: {', '.join(present)}; leave one of them")
        return present[0] if present else None

    def listed(self) -> str:
        """What columns there are."""
        more = "" if len(self.names) <= MOST_NAMED else " ..."
        return f"the columns are {', '.join(name[:40] for name in self.names[:MOST_NAMED])}{more}"

    def get(self, name: str) -> Floats:
        """The values of a column, finite throughout."""
        column = self._raw(name)
        wrong = np.flatnonzero(~np.isfinite(column))
        if len(wrong):
            raise self._missing(column, int(wrong[0]), name)
        return column

    def bridge(self, name: str, time: Floats) -> Floats:
        """As `get`, with short gaps filled by a cubic spline through the samples on both sides.

        Args:
            time: (S,) s.
        """
        column = self._raw(name)
        seen = np.isfinite(column)
        if seen.all():
            return column
        first = int(np.argmin(seen))
        if np.isinf(column).any() or seen.sum() < 4 or not (seen[0] and seen[-1]):
            raise self._missing(column, first if seen[0] else 0, name)
        gaps = np.diff(time[seen])
        longest = int(gaps.argmax())
        if gaps[longest] > LONGEST_GAP + float(np.median(np.diff(time))):
            place = int(np.flatnonzero(seen)[longest]) + 1
            raise self._missing(column, place, name, f" for {gaps[longest]:.2g} s; up to {LONGEST_GAP:g} s are bridged")
        self.bridged += int((~seen).sum())
        return np.where(seen, column, CubicSpline(time[seen], column[seen])(time))

    def time(self) -> Floats:
        """Times (S,), s, even if they are but for having been rounded."""
        name = self.only("times", list(TIMES))
        if name is None:
            raise self.error(f"no column of time; name one `time_s`; {self.listed()}")
        return TIMES[name] * _evened(self.get(name), self._decimals(name))

    def place(self, name: str, time: Floats) -> Floats | None:
        """Values (S,) of a length, m, as `bridge`; None if no column holds it."""
        column = self.only(f"the place {name!r}", with_units([name], list(LENGTHS)))
        return None if column is None else LENGTHS[column[len(name) :]] * self.bridge(column, time)

    def error(self, message: str, column: str = "", line: int = 0) -> SignalError:
        """An error about the file, or one of its columns."""
        inside = f"motion {self.motion}: " if self.table is None else ""
        return SignalError(f"{inside}{f'column {column!r}: ' if column else ''}{message}", "", self.path, line)

    def line(self, sample: int) -> int:
        """Of the file, in which a sample stands; 0 in arrays."""
        return 0 if self.table is None else int(self.table.lines[sample])

    def _raw(self, name: str) -> Floats:
        if self.table is None:
            column = self.arrays[name]
            if column.dtype.kind not in "iuf":
                raise self.error(f"holds values of type {column.dtype}, not numbers", name)
            return np.asarray(column, dtype=np.float64)
        return self.table.columns([self.names.index(name)], gaps=True)[:, 0]

    def _missing(self, column: Floats, sample: int, name: str, more: str = "") -> SignalError:
        what = f"the value is {column[sample]}, not a finite number{more}"
        return self.error(what, name, self.line(sample))

    def _decimals(self, name: str) -> int | None:
        """How many decimals the times of a table were rounded to, None if nothing tells."""
        if self.table is None:
            return None
        at = self.names.index(name)
        found = [_ROUNDED.match(self.table.cell(row, at).strip()) for row in range(len(self.table.rows))]
        return max((len(match[1] or "") for match in found if match), default=None) if all(found) else None


def _evened(time: Floats, decimals: int | None) -> Floats:
    """Even times of which these are the nearest with so many decimals; these if there are none.

    Rounding makes steps of two lengths, both often; a step that is seldom longer is where a sample is missing.
    """
    if decimals is None or len(time) < 3:
        return time
    count, unit = np.arange(len(time)), 10.0**-decimals
    steps = np.round(np.diff(time) / unit)
    longer = float(np.mean(steps > steps.min()))
    if steps.min() < 1.0 or np.ptp(steps) != 1.0 or not SELDOM < longer < 1.0 - SELDOM:
        return time
    even = np.polyval(np.polyfit(count, time, 1), count)
    # A line of least squares through rounded times is not quite the one that they were rounded from.
    return even if np.abs(time - even).max() <= 0.6 * unit else time
