"""STL, as text and as bytes: triangles one by one, whose equal corners are joined."""

from __future__ import annotations

import re

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.meshes.triangles import MeshError, Triangles, numbers

HEAD, COUNT, FACET = 80, 4, 50  # bytes
LAYOUT = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
VERTEX = re.compile(rb"\bvertex\s+(\S+\s+\S+\s+\S+)")


def triangles(data: bytes) -> Triangles:
    """The triangles of a file; raises MeshError if it is damaged."""
    if len(data) >= HEAD + COUNT:
        count = int(np.frombuffer(data, "<u4", 1, HEAD)[0])
        if len(data) == HEAD + COUNT + FACET * count or data.lstrip()[:5] != b"solid":
            if len(data) < HEAD + COUNT + FACET * count:
                raise MeshError(f"it ends before its {number_of(count, 'triangle')} do")
            facets = np.frombuffer(data, LAYOUT, count, HEAD + COUNT)
            return _joined(facets["corners"].reshape(-1, 3).astype(np.float64))
    if data.lstrip()[:5] != b"solid":
        raise MeshError("it is neither STL as text, which begins with `solid`, nor as bytes")
    found = VERTEX.findall(data)
    if len(found) % 3:
        raise MeshError("a facet does not have three corners")
    return _joined(numbers(b" ".join(found), "vertex").reshape(-1, 3))


def _joined(corners: Floats) -> Triangles:
    """Triangles from their corners (3 F, 3), equal ones as one."""
    places, at = np.unique(corners, axis=0, return_inverse=True)
    return Triangles(places, np.asarray(at, dtype=np.int64).reshape(-1, 3))
