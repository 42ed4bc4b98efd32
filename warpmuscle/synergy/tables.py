"""Tables of numbers in text files: comma-, semicolon-, tab- or space-separated values, and OpenSim's .mot and .sto."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SceneError, SignalError
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.plain_text import number_of

STORAGE = (".mot", ".sto")
LONGEST_ROW = 100_000  # characters; Python reads cells of a little more
UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # byte order marks of what Excel calls Unicode text
_NUMBERS = msgspec.json.Decoder(list[float])
_MINUS_ZERO = re.compile(r"-0(?![.\deE])")
_COUNT = re.compile(r"\s*(nrows|datarows|ncolumns|datacolumns)(?:\s*=|\s+(?=[-+.\d]))\s*(.*?)\s*$", re.IGNORECASE)
_DIGITS = re.compile(r"\d{1,15}", re.ASCII)
_DEGREES = re.compile(r"\s*indegrees\s*[= ]\s*(yes|no)\s*$", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"(?<![\d,.])[-+]?(0,\d+|\d+,(\d{1,2}|\d{4,}))(?![\d,.])")  # 1,234 may be a thousand


@dataclass(frozen=True)
class Table:
    """A header of names, and rows of cells below it that are text so far."""

    path: Path
    names: tuple[str, ...]
    rows: list[str]
    lines: Integers  # of the rows in the file, counted from 1
    delimiter: str | None  # None for white space
    degrees: bool | None = None  # what the header of a storage file says of angles, None if it says nothing

    def columns(self, chosen: Sequence[int], gaps: bool = False) -> Floats:
        """Numbers (rows, columns) of some columns; words are errors, `nan` is not.

        Args:
            gaps: whether empty cells count as NaN; else they are errors as well.

        Raises:
            SignalError: a cell holds no number.
        """
        if not self.rows:
            return np.zeros((0, len(chosen)))
        if (every := self._plain_numbers()) is not None:
            return every[:, list(chosen)]
        try:
            return np.loadtxt(
                self.rows, delimiter=self.delimiter, usecols=list(chosen), ndmin=2, comments=None, quotechar='"'
            )
        except ValueError:
            return self._cell_by_cell(chosen, gaps)

    def _plain_numbers(self) -> Floats | None:
        """All cells (rows, columns), if each is a number as JSON has them: four times as fast as by NumPy."""
        plain = self.rows if self.delimiter is not None else [",".join(row.split()) for row in self.rows]
        text = _MINUS_ZERO.sub("-0.0", ",".join(plain).replace(self.delimiter or ",", ","))  # whole ones have no sign
        try:
            found = _NUMBERS.decode(f"[{text}]")
        except (msgspec.DecodeError, UnicodeEncodeError):
            return None
        if len(found) != len(self.rows) * len(self.names):
            return None  # commas within cells
        return np.array(found).reshape(len(self.rows), -1)

    def cell(self, row: int, column: int) -> str:
        """The text of a cell."""
        return _cells(self.rows[row], self.delimiter)[column]

    def _cell_by_cell(self, chosen: Sequence[int], gaps: bool) -> Floats:
        """As `columns`, slower; raises SignalError about the first cell that holds no number."""
        values = np.full((len(self.rows), len(chosen)), np.nan)
        for row, (line, text) in enumerate(zip(self.lines.tolist(), self.rows, strict=True)):
            cells = _cells(text, self.delimiter)
            for place, column in enumerate(chosen):
                if gaps and not cells[column].strip():
                    continue
                try:
                    values[row, place] = _number(cells[column])
                except ValueError:
                    what = f"{cells[column]!r} is not a number" if cells[column].strip() else "the cell is empty"
                    what += "; write # before a row of units" if row == 0 and cells[column].strip() else ""
                    raise SignalError(what, self.names[column], self.path, line) from None
        return values


def read_table(path: str | Path) -> Table:
    """Read a table whose first row, but for lines that begin with #, names the columns.

    Commas are decimal ones if other characters separate cells, no number has a point and some cannot be thousands.

    Raises:
        SignalError: the file cannot be read, is not text, is empty, has no names, or rows of unequal length.
    """
    path = Path(path)
    text = file_text(path)
    lines = text.splitlines()
    begin, promised, degrees = _header(path, lines) if path.suffix.lower() in STORAGE else (0, {}, None)
    numbered = [(number, line) for number, line in enumerate(lines[begin:], start=begin + 1)
                if (own := line.lstrip()) and own[0] != "#"]  # fmt: skip
    if not numbered:
        raise SignalError("is empty: it holds no row of names", file=path)
    if path.suffix.lower() in STORAGE:  # rows of OpenSim's own files may end in blanks or tabs
        numbered = [(number, line.rstrip()) for number, line in numbered]
    long = next((number for number, line in numbered if len(line) > LONGEST_ROW), 0)
    if long:
        raise SignalError(f"a row is longer than {LONGEST_ROW} characters", file=path, line=long)
    first, header = numbered[0]
    delimiter = next((mark for mark in "\t;," if mark in header.strip()), None)
    names = tuple(cell.strip() for cell in _cells(header, delimiter))
    if all(map(_is_number, names)):
        raise SignalError("the first row must name the columns, it holds numbers", file=path, line=first)
    rows, numbers = [line for _, line in numbered[1:]], [number for number, _ in numbered[1:]]
    if delimiter != "," and not any("." in row for row in rows) and any(map(_DECIMAL_COMMA.search, rows)):
        rows = [row.replace(",", ".") for row in rows]
    _check_lengths(path, rows, numbers, delimiter, len(names))
    for key, count in promised.items():
        found = len(rows) if "row" in key.lower() else len(names)
        if found != count:
            raise SignalError(f"the header promises {key}={count}, but there are {found}", file=path)
    return Table(path, names, rows, np.array(numbers, np.int64), delimiter, degrees)


def finite_columns(table: Table, columns: Sequence[int], names: Sequence[str]) -> Floats:
    """Columns (F, n) of a table by their numbers, which have rows of finite numbers.

    Args:
        names: of these columns, for messages.

    Raises:
        SignalError: with the file, the name and the line.
    """
    values = table.columns(columns)
    if not len(values):
        raise SignalError("has no rows", file=table.path)
    for name, column in zip(names, values.T, strict=True):
        if not np.isfinite(column).all():
            line = int(table.lines[int(np.argmin(np.isfinite(column)))])
            raise SignalError(f"column {name!r} is not a finite number", file=table.path, line=line)
    return values


def check_rising(table: Table, times: Floats) -> None:
    """SignalError with file and line unless the times of a table's rows increase."""
    if np.any(np.diff(times) <= 0.0):
        line = int(table.lines[int(np.argmax(np.diff(times) <= 0.0)) + 1])
        raise SignalError("times must increase from row to row", file=table.path, line=line)


def _check_lengths(path: Path, rows: list[str], numbers: list[int], delimiter: str | None, columns: int) -> None:
    """SignalError with the number of the first row that has not a cell for each column."""
    for number, row in zip(numbers, rows, strict=True):
        plain = delimiter is not None and '"' not in row
        count = row.count(str(delimiter)) + 1 if plain else len(_cells(row, delimiter))
        if count != columns:
            what = f"has {number_of(count, 'cell')} where the header names {number_of(columns, 'column')}"
            what += "; write # before lines above the row of names" if number == numbers[0] else ""
            raise SignalError(what, file=path, line=number)


def _header(path: Path, lines: list[str]) -> tuple[int, dict[str, int], bool | None]:
    """Number of lines up to and with `endheader`, and what they say: counts of rows and columns, angles in degrees."""
    promised: dict[str, int] = {}
    degrees = None
    for index, line in enumerate(lines):
        if line.strip().lower() == "endheader":
            return index + 1, promised, degrees
        if found := _COUNT.match(line):
            if not _DIGITS.fullmatch(found[2]):
                raise SignalError(f"{found[1]}={found[2][:40]!r} is not a count", file=path, line=index + 1)
            promised[found[1]] = int(found[2])
        elif found := _DEGREES.match(line):
            degrees = found[1].lower() == "yes"
    raise SignalError("has no line `endheader`, as OpenSim's storage files have", file=path)


def file_text(path: Path) -> str:
    """The text of a file; raises SignalError if it cannot be read, is empty or is none."""
    try:
        content = read_file(path, "table")
    except FileNotFoundError:
        raise SignalError("there is no such file", file=path) from None
    except IsADirectoryError:
        raise SignalError("this is a folder, not a file", file=path) from None
    except SceneError as error:
        raise SignalError(error.message, file=path) from None
    except (OSError, ValueError) as error:
        raise SignalError(unreadable(error), file=path) from None
    if not content.strip():
        raise SignalError("is empty", file=path)
    try:
        text = content.decode("utf-16" if content.startswith(UTF_16) else "utf-8-sig")
        if "\0" in text:
            raise ValueError
        return text
    except ValueError:
        raise SignalError("is not a text file in UTF-8", file=path) from None


def _cells(row: str, delimiter: str | None) -> list[str]:
    return row.split() if delimiter is None else next(csv.reader([row.strip("\r\n")], delimiter=delimiter))


def _number(cell: str) -> float:
    """What a cell holds; raises ValueError if it is no number. Python alone takes 1_0 for one."""
    return float(cell if "_" not in cell else "")


def _is_number(cell: str) -> bool:
    try:
        _number(cell)
    except ValueError:
        return False
    return True
