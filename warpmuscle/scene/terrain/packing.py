"""Heights of a height field as text of a scene."""

from __future__ import annotations

import base64
import binascii
import zlib
from functools import lru_cache

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.scene.terrain.tiles import HeightField


def packed(heights: Floats) -> tuple[tuple[int, int], str]:
    """Points along x and z, and text, of heights (points along z, points along x), m."""
    data = np.ascontiguousarray(heights, dtype="<f4")
    text = base64.b64encode(zlib.compress(data.tobytes(), 6)).decode()
    return (data.shape[1], data.shape[0]), text


def unpacked(tile: HeightField) -> Floats:
    """Heights (points along z, points along x), m.

    Raises:
        ValueError: the text is damaged, or of another number of points.
    """
    return _unpacked(tile.packed, *tile.points)


@lru_cache(maxsize=8)
def _unpacked(text: str, columns: int, rows: int) -> Floats:
    size = 4 * columns * rows
    try:
        reader = zlib.decompressobj()
        data = reader.decompress(base64.b64decode(text, validate=True), size + 1)
    except (binascii.Error, zlib.error, ValueError):
        raise ValueError("the packed heights are damaged") from None
    if len(data) != size:
        raise ValueError(f"the packed heights are not those of a grid of {columns} x {rows}")
    heights = np.frombuffer(data, dtype="<f4").astype(np.float64).reshape(rows, columns)
    heights.flags.writeable = False
    return heights
