"""Tables of numbers in text files: comma-, semicolon-, tab- or space-separated values, and OpenSim's .mot and .sto."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SceneError, SignalError
from warpmuscle.core.files import read_file, unreadable

STORAGE = (".mot", ".sto")
LONGEST_ROW = 100_000  # characters; Python reads cells of a little more
_COUNT = re.compile(r"\s*(nrows|datarows|ncolumns|datacolumns)\s*[= ]\s*(\d+)\s*$", re.IGNORECASE)


@dataclass(frozen=True)
class Table:
    """A header of names, and rows of cells below it that are text so far."""

    path: Path
    names: tuple[str, ...]
    rows: list[str]
    lines: Integers  # of the rows in the file, counted from 1
    delimiter: str | None  # None for white space

    def columns(self, chosen: Sequence[int]) -> Floats:
        """Numbers (rows, columns) of some columns; empty cells and words are errors, `nan` is not.

        Raises:
            SignalError: a cell holds no number.
        """
        if not self.rows:
            return np.zeros((0, len(chosen)))
        try:
            return np.loadtxt(
                self.rows, delimiter=self.delimiter, usecols=list(chosen), ndmin=2, comments=None, quotechar='"'
            )
        except ValueError as error:
            raise self._first_wrong(chosen) or SignalError(str(error), file=self.path) from None

    def _first_wrong(self, chosen: Sequence[int]) -> SignalError | None:
        """An error about the first cell of these columns that holds no number."""
        for line, row in zip(self.lines.tolist(), self.rows, strict=True):
            cells = _cells(row, self.delimiter)
            for column in chosen:
                try:
                    float(cells[column])
                except ValueError:
                    what = f"{cells[column]!r} is not a number" if cells[column].strip() else "the cell is empty"
                    return SignalError(what, self.names[column], self.path, line)
        return None


def read_table(path: str | Path) -> Table:
    """Read a table whose first row, but for lines that begin with #, names the columns.

    Raises:
        SignalError: the file cannot be read, is not text, is empty, has no names, or rows of unequal length.
    """
    path = Path(path)
    text = _text(path)
    lines = text.splitlines()
    begin, promised = _header(path, lines) if path.suffix.lower() in STORAGE else (0, {})
    numbered = [(number, line) for number, line in enumerate(lines[begin:], start=begin + 1)
                if line.strip() and not line.lstrip().startswith("#")]  # fmt: skip
    if not numbered:
        raise SignalError("is empty: it holds no row of names", file=path)
    long = next((number for number, line in numbered if len(line) > LONGEST_ROW), 0)
    if long:
        raise SignalError(f"a row is longer than {LONGEST_ROW} characters", file=path, line=long)
    first, header = numbered[0]
    delimiter = next((mark for mark in "\t;," if mark in header.strip()), None)
    names = tuple(cell.strip() for cell in _cells(header, delimiter))
    if all(map(_is_number, names)):
        raise SignalError("the first row must name the columns, it holds numbers", file=path, line=first)
    rows, numbers = [line for _, line in numbered[1:]], [number for number, _ in numbered[1:]]
    for number, row in zip(numbers, rows, strict=True):
        plain = delimiter is not None and '"' not in row
        count = row.count(str(delimiter)) + 1 if plain else len(_cells(row, delimiter))
        if count != len(names):
            raise SignalError(f"has {count} cells where the header names {len(names)} columns", file=path, line=number)
    for key, count in promised.items():
        found = len(rows) if "row" in key else len(names)
        if found != count:
            raise SignalError(f"the header promises {key}={count}, but there are {found}", file=path)
    return Table(path, names, rows, np.array(numbers, np.int64), delimiter)


def _header(path: Path, lines: list[str]) -> tuple[int, dict[str, int]]:
    """Number of lines up to and with `endheader`, and the counts of rows and columns that these promise."""
    promised: dict[str, int] = {}
    for index, line in enumerate(lines):
        if line.strip().lower() == "endheader":
            return index + 1, promised
        found = _COUNT.match(line)
        if found:
            promised[found[1]] = int(found[2])
    raise SignalError("has no line `endheader`, as OpenSim's storage files have", file=path)


def _text(path: Path) -> str:
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
        if b"\0" in content:
            raise ValueError
        return content.decode("utf-8-sig")
    except ValueError:
        raise SignalError("is not a text file", file=path) from None


def _cells(row: str, delimiter: str | None) -> list[str]:
    return row.split() if delimiter is None else next(csv.reader([row.strip("\r\n")], delimiter=delimiter))


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
