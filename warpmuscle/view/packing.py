"""Arrays as short text for a page: quantised, as differences between frames, compressed.

An array of F frames and C columns is stored column by column: each from its least value to its greatest in 255 or
65535 steps, as the difference from the frame before (modulo 2^8 or 2^16), low bytes before high bytes. What is not
finite is stored as 0. `assets/unpack.js` is the way back.
"""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats


class Packer:
    """Collects arrays, and gives each a number by which the page finds it."""

    def __init__(self) -> None:
        self._table: list[dict[str, Any]] = []
        self._bytes: list[bytes] = []

    def add(self, array: Floats, bits: int = 16) -> int:
        """Add an array (F, ...) of at least one frame; returns its number. `bits` is 8 or 16."""
        values = np.asarray(array, dtype=np.float64)
        flat = np.nan_to_num(values.reshape(len(values), -1), posinf=0.0, neginf=0.0)
        low, high = flat.min(axis=0), flat.max(axis=0)
        steps = 2**bits - 1
        width = np.where(high > low, high - low, 1.0)
        whole = np.rint((flat - low) / width * steps).astype(np.uint16 if bits == 16 else np.uint8)
        change = np.diff(whole, axis=0, prepend=np.zeros_like(whole[:1])).T  # wraps around, like the way back
        entry = {"shape": list(values.shape), "bits": bits, "low": _short(low), "width": _short(width)}
        self._table.append(entry)
        parts = [change & 255, change >> 8] if bits == 16 else [change]
        self._bytes += [np.ascontiguousarray(part, dtype=np.uint8).tobytes() for part in parts]
        return len(self._table) - 1

    def table(self) -> list[dict[str, Any]]:
        """What the arrays are, for the page."""
        return self._table

    def text(self) -> str:
        """The arrays as base64 of a zlib stream."""
        return base64.b64encode(zlib.compress(b"".join(self._bytes), 9)).decode("ascii")


def _short(numbers: Floats) -> list[float]:
    """Numbers with seven digits."""
    return [float(f"{number:.7g}") for number in numbers]


def packed_json(content: Any) -> str:
    """JSON as base64 of a zlib stream, which can stand in a page whatever its strings hold."""
    text = json.dumps(content, separators=(",", ":"), allow_nan=False)
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode("ascii")


def without_comments(script: str) -> str:
    """A script or style sheet without lines of comment and the space at the beginning of lines."""
    lines = (line.strip() for line in script.splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("//"))


def whole(text: str) -> str:
    """A text without the halves of letters that names of files and of Python may hold, which no page can."""
    return text.encode(errors="replace").decode()
