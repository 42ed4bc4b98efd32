"""Writes C3D files by the format's own description (c3d.org), so that what reads them is not what has written them."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

BLOCK = 512
Parameter = Sequence[str] | str | float | int | np.ndarray


def write_c3d(
    path: Path, points: np.ndarray, labels: Sequence[str], rate: float, analogs: np.ndarray,
    channels: Sequence[str], units: Sequence[str], groups: Mapping[str, Mapping[str, Parameter]] | None = None,
    unit: str = "mm", scale: Sequence[float] | None = None, offset: Sequence[int] | None = None,
) -> Path:  # fmt: skip
    """Write points (F, K, 3), NaN where one was not seen, and analog values (F * s, C), of s samples a frame.

    Args:
        scale, offset: of the channels; what is stored is value / scale + offset. groups: further ones, by name.
    """
    frames, samples = len(points), len(analogs) // max(len(points), 1)
    scales, offsets = np.array(scale or np.ones(len(channels))), np.array(offset or np.zeros(len(channels), int))
    every: dict[str, dict[str, Parameter]] = {
        "POINT": {"USED": len(labels), "SCALE": -1.0, "RATE": float(rate), "FRAMES": frames, "LABELS": list(labels),
                  "UNITS": unit, "DATA_START": 0},
        "ANALOG": {"USED": len(channels), "LABELS": list(channels), "GEN_SCALE": 1.0, "SCALE": scales.astype(float),
                   "OFFSET": offsets.astype(int), "UNITS": list(units), "RATE": float(rate * samples)},
    }  # fmt: skip
    for name, group in (groups or {}).items():
        every.setdefault(name, {}).update(group)
    blocks = -(-len(_parameters(every)) // BLOCK)
    every["POINT"]["DATA_START"] = 2 + blocks
    head = struct.pack("<BBHHHHHfHHf", 2, 0x50, len(labels), len(channels) * samples, 1, frames, 0, -1.0, 2 + blocks,
                       samples, rate)  # fmt: skip
    stored = (analogs / scales + offsets).reshape(frames, samples * len(channels))
    seen = ~np.isnan(points).any(axis=2)
    four = np.where(seen[..., None], points, 0.0)
    rows = np.concatenate([np.concatenate([four, np.where(seen, 0.0, -1.0)[..., None]], axis=2).reshape(frames, -1),
                           stored], axis=1)  # fmt: skip
    body = bytearray(_parameters(every).ljust(blocks * BLOCK, b"\0"))
    body[2] = blocks
    path.write_bytes(head.ljust(BLOCK, b"\0") + bytes(body) + rows.astype("<f4").tobytes())
    return path


def _parameters(groups: Mapping[str, Mapping[str, Parameter]]) -> bytes:
    text = struct.pack("<BBBB", 1, 0x50, 0, 84)  # Intel's order of bytes
    records = []
    for number, (name, group) in enumerate(groups.items(), start=1):
        records.append((struct.pack("<bb", len(name), -number) + name.encode(), b"\0"))
        for word, value in group.items():
            records.append((struct.pack("<bb", len(word), number) + word.encode(), _value(value) + b"\0"))
    for k, (begin, end) in enumerate(records):
        last = k == len(records) - 1
        text += begin + struct.pack("<h", 0 if last else len(end) + 2) + end
    return text


def _value(value: Any) -> bytes:
    if isinstance(value, str):
        return struct.pack("<bBB", -1, 1, len(value)) + value.encode()
    if isinstance(value, list | tuple) and all(isinstance(one, str) for one in value):
        width = max([1, *map(len, value)])
        cells = b"".join(one.ljust(width).encode() for one in value)
        return struct.pack("<bBBB", -1, 2, width, len(value)) + cells
    array = np.asarray(value)
    kind, order = (2, "<i2") if array.dtype.kind in "iub" else (4, "<f4")
    dims = struct.pack(f"<{array.ndim}B", *array.shape)
    return struct.pack("<bB", kind, array.ndim) + dims + array.astype(order).tobytes(order="F")  # first index fastest


def plate_channels(
    kind: int, corners: np.ndarray, origin: np.ndarray, force: np.ndarray, point: np.ndarray, moment: np.ndarray,
    of_foot: bool = False,
) -> np.ndarray:  # fmt: skip
    """Channels (T, 6 or 8) that a plate of kind 1, 2 or 3 has under forces on the foot, N, mm and N mm.

    Args:
        corners: (4, 3) mm, room axes. origin: (3,) mm, as FORCE_PLATFORM:ORIGIN has it. force, point, moment: (T, 3) N,
            mm and N mm about the point, room axes. of_foot: whether the plate tells the forces of the foot on it.
    """
    sign = -1.0 if of_foot else 1.0
    x = corners[0] - corners[1]
    y = corners[1] - corners[2]
    axes = np.stack([x / np.linalg.norm(x), y / np.linalg.norm(y), np.cross(x, y) / np.linalg.norm(np.cross(x, y))])
    force, moment, arm = sign * force @ axes.T, sign * moment @ axes.T, (point - corners.mean(axis=0)) @ axes.T
    if kind == 1:
        return np.column_stack([force, arm[:, :2] + origin[:2], moment[:, 2]])
    below = np.array([0.0, 0.0, origin[2]]) if kind == 3 else origin
    about = moment + np.cross(arm + below, force)  # the sensors' origin, to which the surface's centre is at `below`
    if kind != 3:
        return np.column_stack([force, about])
    a, b = origin[:2]
    places = np.array([[a, b], [-a, b], [-a, -b], [a, -b]])  # of sensors 1 to 4
    rows = np.zeros((6, 8))
    rows[0, :2] = rows[1, 2:4] = rows[2, 4:] = 1.0
    rows[3, 4:], rows[4, 4:] = places[:, 1], -places[:, 0]
    rows[5, :4] = [-b, b, a, -a]
    return np.column_stack([force, about]) @ np.linalg.pinv(rows).T
