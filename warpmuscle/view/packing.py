"""Arrays as short text for a page: quantised, as differences between frames, compressed.

An array of F frames and C columns is stored column by column: each from its least value to its greatest in 2^bits - 1
steps, or in steps that all columns have in common, as the difference from the frame before (modulo 2^8, or 2^16 of more
than 8 bits), low bytes before high bytes. Wide steps make small differences, which compress well. What is not finite is
stored as 0. `assets/unpack.js` is the way back.
"""

from __future__ import annotations

import base64
import json
import math
import zlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats

LARGEST = 960_000  # bytes of a page: below a megabyte within another page, too
FEWER = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)  # one frame of so many is kept


class Packer:
    """Collects arrays, and gives each a number by which the page finds it."""

    def __init__(self) -> None:
        self._table: list[dict[str, Any]] = []
        self._bytes: list[bytes] = []
        self._known: dict[Any, int] = {}  # numbers, by what the page gets of an array

    def add(self, array: Floats, fineness: float = 16) -> int:
        """Add an array (F, ...) of at least one frame; returns its number, which equal arrays have in common.

        Args:
            fineness: how many bits, 8 to 16, the range of each column has; or below 1, the step of all columns, in the
                unit of the array, which is wider where a range has more than 65535 of them.
        """
        values = np.asarray(array, dtype=np.float64)
        flat = np.nan_to_num(values.reshape(len(values), -1), posinf=0.0, neginf=0.0)
        low, high = flat.min(axis=0), flat.max(axis=0)
        width, bits = np.where(high > low, high - low, 1.0), int(fineness)
        if fineness < 1:
            most = float((high - low).max(initial=0.0))
            bits = min(max(math.ceil(math.log2(most / fineness + 1.0)), 8), 16)
            width = np.full_like(low, max(fineness * (2**bits - 1), most))
        whole = np.rint((flat - low) / width * (2**bits - 1)).astype(np.uint16 if bits > 8 else np.uint8)
        change = np.diff(whole, axis=0, prepend=np.zeros_like(whole[:1])).T  # wraps around, like the way back
        lows, widths = _short(low), _short(width)
        parts = [change & 255, change >> 8] if bits > 8 else [change]
        content = b"".join(np.ascontiguousarray(part, dtype=np.uint8).tobytes() for part in parts)
        key = (values.shape, bits, tuple(lows), tuple(widths), content)
        if key not in self._known:
            self._known[key] = len(self._table)
            self._table.append({"shape": list(values.shape), "bits": bits, "low": lows, "width": widths})
            self._bytes.append(content)
        return self._known[key]

    def add_all(self, arrays: Mapping[str, tuple[Floats, float]]) -> dict[str, int]:
        """Add arrays with how finely they are stored, see `add`; returns the number of each."""
        return {name: self.add(values, fineness) for name, (values, fineness) in arrays.items()}

    def table(self) -> list[dict[str, Any]]:
        """What the arrays are, for the page."""
        return self._table

    def text(self) -> str:
        """The arrays as base64 of a zlib stream."""
        return base64.b64encode(zlib.compress(b"".join(self._bytes), 9)).decode("ascii")


class Pool:
    """Collects arrays that many motions have alike, to be packed as one behind the other: ranges are told once."""

    def __init__(self) -> None:
        self._parts: list[list[Floats]] = []
        self._fineness: list[float] = []
        self._places: dict[tuple[str, int], int] = {}

    def add_all(self, arrays: Mapping[str, tuple[Floats, float]]) -> dict[str, int]:
        """Add the arrays (F, ...) of a motion, see `Packer.add_all`; returns the place of each here."""
        return {name: self._add(name, values, fineness) for name, (values, fineness) in arrays.items()}

    def _add(self, name: str, values: Floats, fineness: float) -> int:
        flat = np.asarray(values, dtype=np.float64).reshape(len(values), -1)
        place = self._places.setdefault((name, flat.shape[1]), len(self._parts))
        if place == len(self._parts):
            self._parts.append([])
            self._fineness.append(fineness)
        self._parts[place].append(flat)
        return place

    def pack(self, packer: Packer, motions: Sequence[dict[str, int]]) -> list[dict[str, tuple[int, int]]]:
        """Pack it all; of each motion, whose places these are, the number of each array and its first row there."""
        numbers = [
            packer.add(np.concatenate(parts), fine) for parts, fine in zip(self._parts, self._fineness, strict=True)
        ]
        taken, rows = [0] * len(numbers), [0] * len(numbers)
        found = []
        for places in motions:
            found.append({name: (numbers[place], rows[place]) for name, place in places.items()})
            for place in places.values():
                rows[place] += len(self._parts[place][taken[place]])
                taken[place] += 1
        return found


def _short(numbers: Floats) -> list[float]:
    """Numbers with seven digits."""
    return [float(f"{number:.7g}") for number in numbers]


def as_small(make: Callable[[float], str], rate: float, largest: int = LARGEST) -> str:
    """A page with fewer frames a second where it would be too large, so that a browser opens it at once.

    Args:
        make: the page with so many frames a second. rate: at first. largest: bytes.
    """
    text = make(rate)
    enough = min(0.5 * len(text.encode()) / largest, FEWER[-1])  # half of a page may be what does not depend on frames
    for every in (number for number in FEWER if number >= enough):
        if len(text.encode()) <= largest:
            break
        text = make(rate / every)
    return text


def packed_json(content: Any) -> str:
    """JSON as base64 of a zlib stream, which can stand in a page whatever its strings hold."""
    text = json.dumps(content, separators=(",", ":"), allow_nan=False)
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode("ascii")


def without_comments(script: str) -> str:
    """A script or style sheet without lines of comment and the space at the beginning of lines."""
    lines = (line.strip() for line in script.splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("//"))


def encodable(text: str) -> str:
    """A text without the halves of letters that names of files and of Python may hold, which no page can."""
    return text.encode(errors="replace").decode()
