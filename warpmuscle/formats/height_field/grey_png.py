"""How bright the points of a PNG picture are, of any kind that the standard has (ISO/IEC 15948)."""

from __future__ import annotations

import struct
import zlib
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats

SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}  # by colour type: grey, colour, palette, grey with alpha, colour with alpha
BITS = {0: (1, 2, 4, 8, 16), 2: (8, 16), 3: (1, 2, 4, 8), 4: (8, 16), 6: (8, 16)}  # of a value, by colour type
PALETTE = 3  # colour type of pictures whose values are numbers of colours
ONE_PASS = ((0, 0, 1, 1),)  # first column, first row and the steps between them, of each pass
# The same of a picture that becomes finer as it comes in (Adam7).
PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))


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
    header, colours, packed = _chunks(data)
    if header.bits not in BITS.get(header.colour, ()) or header.interlaced > 1:
        raise ValueError("the picture is of no kind that PNG has")
    if header.width * header.height > most:
        raise ValueError(f"a grid of {header.width} x {header.height} has more points than {most}, the limit `heights`")
    passes = _sizes(header)
    size = sum(rows * (line + 1) for _, rows, _, line in passes)
    try:
        raw = zlib.decompressobj().decompress(packed, size + 1)
    except zlib.error:
        raise ValueError("the picture is damaged: its data cannot be unpacked") from None
    if len(raw) != size:
        raise ValueError("the picture is damaged: it has more or fewer points than it says")
    channels = CHANNELS[header.colour]
    values, at = np.empty((header.height, header.width, channels)), 0
    for (column, row, across, down), rows, columns, line in passes:
        lines = np.frombuffer(raw, np.uint8, rows * (line + 1), at).reshape(rows, line + 1)
        at += lines.size
        plain = _unfiltered(lines, max(header.bits * channels // 8, 1))
        values[row::down, column::across] = _values(plain, header.bits, columns * channels).reshape(rows, columns, -1)
    if header.colour == PALETTE:
        if values.max() >= len(colours):
            raise ValueError("the picture is damaged: it has more colours than its palette")
        return np.asarray(colours.mean(axis=1)[values[..., 0].astype(int)] / 255.0)
    grey = values[..., : 3 if header.colour & 2 else 1].mean(axis=2)
    return np.asarray(grey / (2**header.bits - 1))


def _sizes(header: Header) -> list[tuple[tuple[int, int, int, int], int, int, int]]:
    """Passes that a picture has points in, each with its rows, its columns and the bytes of a row."""
    found = []
    for column, row, across, down in PASSES if header.interlaced else ONE_PASS:
        rows, columns = -(-(header.height - row) // down), -(-(header.width - column) // across)
        if rows > 0 and columns > 0:
            line = -(-columns * CHANNELS[header.colour] * header.bits // 8)
            found.append(((column, row, across, down), rows, columns, line))
    return found


def _values(plain: Any, bits: int, count: int) -> Any:
    """So many values of each row of bytes."""
    if bits == 16:
        return plain.view(">u2")
    if bits == 8:
        return plain
    one_by_one = np.unpackbits(plain, axis=1).reshape(len(plain), -1, bits)
    return (one_by_one @ (1 << np.arange(bits)[::-1]))[:, :count]


def _chunks(data: bytes) -> tuple[Header, Any, bytes]:
    """The header, the colours (n, 3) of a palette, and the data of the picture, still packed."""
    if not data.startswith(SIGNATURE):
        raise ValueError("this is not a PNG picture")
    at, header, parts = len(SIGNATURE), None, []
    colours = np.zeros((0, 3), np.uint8)
    while at + 12 <= len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body, end = data[at + 8 : at + 8 + length], at + 12 + length
        if end > len(data) or zlib.crc32(kind + body) != struct.unpack(">I", data[end - 4 : end])[0]:
            raise ValueError("the picture is damaged: a part of it is cut off or changed")
        if kind == b"IHDR" and length == 13:
            header = Header(*struct.unpack(">IIBBBBB", body))
        elif kind == b"PLTE" and length % 3 == 0:
            colours = np.frombuffer(body, np.uint8).reshape(-1, 3)
        elif kind == b"IDAT":
            parts.append(body)
        elif kind == b"IEND":
            break
        at = end
    if header is None or not parts or not (header.width and header.height):
        raise ValueError("the picture is damaged: it has no points")
    return header, colours, b"".join(parts)


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
            raise ValueError(f"the picture is damaged: line {row + 1} has the filter {kind}, which does not exist")
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
