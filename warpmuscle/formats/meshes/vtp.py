"""VTK's XML of polygons: numbers as text, as base64 within elements, or behind them all, compressed by zlib or not."""

from __future__ import annotations

import base64
import binascii
import math
import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.limits import LIMITS
from warpmuscle.formats.meshes.triangles import MeshError, Triangles, as_integers, fans, numbers

APPENDED = re.compile(rb"<AppendedData\b([^>]*)>\s*_")
TYPES = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4", "Int64": "i8",
    "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
DEEPEST = 20  # elements in each other
COMPRESSOR = "vtkZLibDataCompressor"


@dataclass
class _Element:
    tag: str
    attributes: dict[str, str]
    children: list[_Element] = field(default_factory=list)
    text: list[str] = field(default_factory=list)

    def child(self, tag: str) -> _Element | None:
        return next((one for one in self.children if one.tag == tag), None)


def triangles(data: bytes) -> Triangles:
    """The polygons of a file as triangles; raises MeshError if it is damaged."""
    behind = APPENDED.search(data)
    raw = b""
    if behind is not None:
        raw = data[behind.end() :]
        data = data[: behind.start()] + b"</VTKFile>"
    root = _parsed(data)
    if root.tag != "VTKFile" or root.attributes.get("type") != "PolyData":
        raise MeshError("a .vtp file is a VTKFile of the type PolyData")
    encoded = behind is not None and b"raw" not in behind[1]
    arrays = _Arrays(root.attributes, raw.rpartition(b"</AppendedData")[0] if encoded else raw, encoded)
    corners: list[Floats] = [np.zeros((0, 3))]
    faces: list[Integers] = [np.zeros((0, 3), dtype=np.int64)]
    offset = 0
    for poly in (one for one in root.children if one.tag == "PolyData"):
        for piece in (one for one in poly.children if one.tag == "Piece"):
            points = arrays.only(piece, "Points")
            if points is None:
                raise MeshError("a <Piece> has no <Points>")
            if len(points) % 3:
                raise MeshError("a point has three numbers")
            corners.append(points.reshape(-1, 3))
            cells = [arrays.named(piece, "Polys", name) for name in ("connectivity", "offsets")]
            if cells[0] is not None and cells[1] is not None:
                made = fans(as_integers(cells[0], "connectivity"), as_integers(cells[1], "offsets"))
                faces.append(made + offset)
            offset += len(corners[-1])
    return Triangles(np.concatenate(corners), np.concatenate(faces))


class _Arrays:
    """Numbers of the elements `DataArray`."""

    def __init__(self, attributes: dict[str, str], raw: bytes, encoded: bool) -> None:
        self._order = ">" if attributes.get("byte_order") == "BigEndian" else "<"
        self._header = np.dtype(self._order + ("u8" if attributes.get("header_type") == "UInt64" else "u4"))
        compressor = attributes.get("compressor", "")
        if compressor not in ("", COMPRESSOR):
            raise MeshError(f"its numbers are compressed by {compressor[:60]!r}; {COMPRESSOR} is known here")
        self._compressed = bool(compressor)
        self._raw, self._encoded = raw, encoded
        self._left = LIMITS["mesh"].most  # bytes of unpacked numbers

    def only(self, piece: _Element, tag: str) -> Floats | None:
        """The one array of an element of a piece."""
        holder = piece.child(tag)
        array = holder.child("DataArray") if holder is not None else None
        return None if array is None else self._numbers(array)

    def named(self, piece: _Element, tag: str, name: str) -> Floats | None:
        """An array of an element of a piece by its name."""
        holder = piece.child(tag)
        for array in holder.children if holder is not None else ():
            if array.tag == "DataArray" and array.attributes.get("Name") == name:
                return self._numbers(array)
        return None

    def _numbers(self, array: _Element) -> Floats:
        kind, form = array.attributes.get("type", ""), array.attributes.get("format", "ascii")
        if kind not in TYPES:
            raise MeshError(f"numbers of the type {kind[:30]!r} are not known")
        what = array.attributes.get("Name", "Points")[:40]
        if form == "ascii":
            return numbers("".join(array.text).encode(), what)
        if form == "binary":
            found = self._unpacked("".join("".join(array.text).split()).encode(), True)
        elif form == "appended":
            text = array.attributes.get("offset", "")
            if not (text.isascii() and text.isdigit() and len(text) < 16):
                raise MeshError(f"{what}: its offset is a number of bytes, not {text[:30]!r}")
            found = self._unpacked(self._raw[int(text) :], self._encoded)
        else:
            raise MeshError(f"{what}: the format {form[:30]!r} is not known")
        dtype = np.dtype(self._order + TYPES[kind])
        return np.frombuffer(found[: len(found) // dtype.itemsize * dtype.itemsize], dtype).astype(np.float64)

    def _unpacked(self, data: bytes, encoded: bool) -> bytes:
        """The bytes of an array that begins here: its length before it, or lengths of its blocks."""
        one = self._header.itemsize
        if not self._compressed:
            (size,) = self._head(data, encoded, 1)
            self._take(size)
            block = _decoded(data, one + size) if encoded else data[: one + size]
            if len(block) < one + size:
                raise MeshError("an array ends before its numbers do")
            return block[one:]
        count, size, last = self._head(data, encoded, 3)
        if count > len(data):
            raise MeshError("an array has more blocks than bytes")
        head = self._head(data, encoded, 3 + count)
        rest = data[_letters(one * len(head)) :] if encoded else data[one * len(head) :]
        body = _decoded(rest, sum(head[3:])) if encoded else rest
        return b"".join(self._blocks(body, head[3:], size, last))

    def _blocks(self, body: bytes, packed: list[int], size: int, last: int) -> Iterator[bytes]:
        at = 0
        for number, length in enumerate(packed):
            most = last if last and number == len(packed) - 1 else size
            self._take(most)
            try:
                yield zlib.decompressobj().decompress(body[at : at + length], most) if most else b""
            except zlib.error:
                raise MeshError("a block is not sound zlib") from None
            at += length

    def _head(self, data: bytes, encoded: bool, count: int) -> list[int]:
        size = self._header.itemsize * count
        head = _decoded(data, size) if encoded else data[:size]
        if len(head) < size:
            raise MeshError("an array ends before it begins")
        return [int(value) for value in np.frombuffer(head[:size], self._header)]

    def _take(self, size: int) -> None:
        self._left -= size
        if self._left < 0:
            raise MeshError(f"its arrays have more bytes than {LIMITS['mesh'].most}, the limit `mesh`")


def _letters(size: int) -> int:
    """Of base64, for so many bytes."""
    return 4 * math.ceil(size / 3)


def _decoded(data: bytes, size: int) -> bytes:
    """The first bytes of base64."""
    try:
        return base64.b64decode(data[: _letters(size)], validate=True)
    except (binascii.Error, struct.error):
        raise MeshError("an array is not sound base64") from None


def _parsed(data: bytes) -> _Element:
    """The elements of a file without document types, which could name other files and grow without end."""
    parser = expat.ParserCreate()
    parser.buffer_text = True
    open_: list[_Element] = [_Element("", {})]

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(open_) > DEEPEST:
            raise MeshError("its elements are nested too deeply")
        open_[-1].children.append(_Element(tag, attributes))
        open_.append(open_[-1].children[-1])

    def doctype(*_: object) -> None:
        raise MeshError("it has a document type, which no mesh needs")

    def characters(text: str) -> None:
        if open_[-1].tag == "DataArray":
            open_[-1].text.append(text)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: open_.pop()
    parser.CharacterDataHandler = characters
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise MeshError(f"line {error.lineno}: not sound XML: {expat.ErrorString(error.code)}") from None
    return open_[0].children[0]
