"""Tables as Vicon Nexus exports them: blocks, each with a heading, its rate, names, `Frame,Sub Frame,...`, and units.

    Trajectories
    100
    ,,Anna:RSHO,,,Anna:RELB,,
    Frame,Sub Frame,X,Y,Z,X,Y,Z
    ,,mm,mm,mm,mm,mm,mm
    1,0,12.5,...

`Devices` hold forces and EMG, and `Trajectories` markers. An empty line ends a block.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.tables import file_text

DEVICES, TRAJECTORIES = "Devices", "Trajectories"
HEADINGS = (DEVICES, TRAJECTORIES, "Model Outputs", "Joints", "Segments", "Events")
HEAD = 5  # lines of a block, from its heading to its units
LEAD = 2  # columns: of the frame and of the sample within it


@dataclass(frozen=True)
class Block:
    """What stands under one heading, C columns besides those of frames."""

    rate: float  # rows a second
    owners: tuple[str, ...]  # (C,), marker or device above each column
    names: tuple[str, ...]  # (C,), unlike each other: with the device's name where two are called alike
    headings: tuple[str, ...]  # (C,), as they stand below the owners
    units: tuple[str, ...]  # (C,)
    values: Floats  # (T, C), NaN where a cell is empty
    lines: Integers  # (T,), of the file


def is_export(path: Path) -> bool:
    """Whether a file begins as these tables do: a heading, and a number alone in the next line."""
    lines = file_text(path).splitlines()[:2]
    if len(lines) < 2:
        return False
    heading, rate = (_alone(line) for line in lines)
    return heading in HEADINGS and _positive(rate) is not None


def vicon_block(path: Path, heading: str) -> Block:
    """One block of such a table.

    Raises:
        SignalError: it is not there, or is not as they are.
    """
    lines = file_text(path).splitlines()
    starts = [k for k, line in enumerate(lines) if _alone(line) in HEADINGS]
    start = next((k for k in starts if _alone(lines[k]) == heading), None)
    if start is None:
        there = ", ".join(_alone(lines[k]) for k in starts) or "no block"
        raise SignalError(f"has no block {heading!r}, but {there}", file=path)
    if len(lines) < start + HEAD:
        raise SignalError(f"ends within the head of {heading!r}", file=path, line=start + 1)
    rate = _positive(_alone(lines[start + 1]))
    if rate is None:
        raise SignalError(f"{lines[start + 1].strip()[:40]!r} is no rate", file=path, line=start + 2)
    mark = next((mark for mark in "\t;," if mark in lines[start + 3]), ",")
    owners, headings, units = (next(csv.reader([lines[start + k]], delimiter=mark), []) for k in (2, 3, 4))
    if [cell.strip() for cell in headings[:LEAD]] != ["Frame", "Sub Frame"]:
        raise SignalError("a row of names must begin with `Frame` and `Sub Frame`", file=path, line=start + 4)
    count = max((k for k, cell in enumerate(headings) if cell.strip()), default=0) + 1
    rows, numbers = [], []
    for number in range(start + HEAD, len(lines)):
        if not lines[number].strip(mark + " \t"):
            break
        rows.append(_row(path, number + 1, next(csv.reader([lines[number]], delimiter=mark)), count, mark))
        numbers.append(number + 1)
    filled = _carried(owners, count)
    own = tuple(cell.strip() for cell in headings[LEAD:count])
    values = np.array(rows, dtype=np.float64).reshape(-1, count)[:, LEAD:]
    units = [cell.strip() for cell in units[LEAD:count]] + [""] * (count - max(len(units), LEAD))
    return Block(rate, filled, _unlike(filled, own), own, tuple(units), values, np.array(numbers, np.int64))


def _alone(line: str) -> str:
    """What stands in the only cell of a line that is not empty."""
    cells = line.lstrip("\ufeff").replace("\t", ",").replace(";", ",").split(",")
    return cells[0].strip().strip('"') if not any(cell.strip() for cell in cells[1:]) else ""


def _positive(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if 0.0 < number < np.inf else None


def _carried(owners: list[str], count: int) -> tuple[str, ...]:
    """Each column's owner, which stands above the first of its columns alone."""
    found, last = [], ""
    for column in range(LEAD, count):
        last = owners[column].strip() if column < len(owners) and owners[column].strip() else last
        found.append(last)
    return tuple(found)


def _unlike(owners: tuple[str, ...], names: tuple[str, ...]) -> tuple[str, ...]:
    pairs = zip(owners, names, strict=True)
    return tuple(name if names.count(name) == 1 else f"{owner} {name}" for owner, name in pairs)


def _row(path: Path, line: int, cells: list[str], count: int, mark: str) -> list[float]:
    """Numbers of a row; commas are decimal ones where something else separates cells."""
    found = []
    for cell in [*cells, *[""] * (count - len(cells))][:count]:
        text = cell.strip() if mark == "," else cell.strip().replace(",", ".")
        try:
            found.append(float(text) if text else np.nan)
        except ValueError:
            raise SignalError(f"{cell.strip()[:40]!r} is not a number", file=path, line=line) from None
    return found
