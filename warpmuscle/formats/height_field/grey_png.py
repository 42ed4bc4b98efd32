"""Grey pictures of 8 or 16 bits in PNG (ISO/IEC 15948)."""

from __future__ import annotations

import struct
import zlib
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats

SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}  # by colour type: grey, colour, grey with alpha, colour with alpha


class Header(NamedTuple):
    """What a picture says of itself."""

    width: int
    height: int
    bits: int
    colour: int
    compression: int
    filtering: int
    interlaced: int


def grey_values(data: bytes, most: int) -> Floats:
    """Brightness (rows, columns) of a picture, 0 to 1, the top row first; of colours their mean, alpha left out.

    Args:
        most: points that it may have.

    Raises:
        ValueError: it is damaged, of another kind, or too large.
    """
    header, packed = _chunks(data)
    if header.bits not in (8, 16) or header.colour not in CHANNELS or header.interlaced:
        raise ValueError("of PNG pictures only those of 8 or 16 bits, without a palette and not interlaced, are read")
    if header.width * header.height > most:
        raise ValueError(f"a grid of {header.width} x {header.height} has more points than {most}, the limit `heights`")
    width = header.bits // 8 * CHANNELS[header.colour]  # bytes of a point
    line = header.width * width
    size = header.height * (line + 1)
    try:
        raw = zlib.decompressobj().decompress(packed, size + 1)
    except zlib.error:
        raise ValueError("the picture is damaged: its data cannot be unpacked") from None
    if len(raw) != size:
        raise ValueError("the picture is damaged: it has more or fewer points than it says")
    lines = np.frombuffer(raw, dtype=np.uint8).reshape(header.height, line + 1)
    plain = _unfiltered(lines, width)
    values = plain.view(">u2") if header.bits == 16 else plain
    values = values.reshape(header.height, header.width, CHANNELS[header.colour])
    colours = values[..., : 3 if header.colour & 2 else 1]
    return np.asarray(colours.mean(axis=2) / (2**header.bits - 1))


def _chunks(data: bytes) -> tuple[Header, bytes]:
    """The header, and the data of the picture, still packed."""
    if not data.startswith(SIGNATURE):
        raise ValueError("this is no PNG picture")
    at, header, parts = len(SIGNATURE), None, []
    while at + 12 <= len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body, end = data[at + 8 : at + 8 + length], at + 12 + length
        if end > len(data) or zlib.crc32(kind + body) != struct.unpack(">I", data[end - 4 : end])[0]:
            raise ValueError("the picture is damaged: a part of it is cut off or changed")
        if kind == b"IHDR" and length == 13:
            header = Header(*struct.unpack(">IIBBBBB", body))
        elif kind == b"IDAT":
            parts.append(body)
        elif kind == b"IEND":
            break
        at = end
    if header is None or not parts or not (header.width and header.height):
        raise ValueError("the picture is damaged: it has no points")
    return header, b"".join(parts)


def _unfiltered(lines: Any, width: int) -> Any:
    """Bytes of all lines, each of which begins with the number of how it follows from its neighbours (section 9)."""
    before = np.zeros(lines.shape[1] - 1, dtype=np.uint8)
    found = np.empty((len(lines), len(before)), dtype=np.uint8)
    for row, line in enumerate(lines):
        kind, now = int(line[0]), line[1:].copy()
        if kind == 2:
            now += before
        elif kind in (1, 3, 4):
            now = _along(kind, now, before, width)
        elif kind != 0:
            raise ValueError(f"the picture is damaged: line {row + 1} has the filter {kind}, which there is not")
        found[row] = before = now
    return found


def _along(kind: int, line: Any, before: Any, width: int) -> Any:
    """A line that follows from what is to the left of each byte, too."""
    if kind == 1:
        sums = np.cumsum(line.reshape(-1, width).astype(np.uint64), axis=0)
        return (sums & 255).astype(np.uint8).ravel()
    up, now = before.tolist(), line.tolist()
    for k in range(len(now)):
        left, corner = (now[k - width], up[k - width]) if k >= width else (0, 0)
        guess = (left + up[k]) // 2 if kind == 3 else _nearest(left, up[k], corner)
        now[k] = (now[k] + guess) & 255
    return np.array(now, dtype=np.uint8)


def _nearest(left: int, up: int, corner: int) -> int:
    """That of three neighbours which is nearest to left + up - corner (section 9.4)."""
    guess = left + up - corner
    from_left, from_up, from_corner = abs(guess - left), abs(guess - up), abs(guess - corner)
    if from_left <= from_up and from_left <= from_corner:
        return left
    return up if from_up <= from_corner else corner
