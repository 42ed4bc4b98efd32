"""Wavefront's OBJ: its corners and faces; textures, normals, groups and materials are left alone."""

from __future__ import annotations

import numpy as np

from warpmuscle.formats.meshes.triangles import MeshError, Triangles, fans, numbers


def triangles(data: bytes) -> Triangles:
    """The triangles of a file; raises MeshError if it is damaged."""
    corners: list[bytes] = []
    used: list[int] = []
    ends: list[int] = []
    for number, line in enumerate(data.replace(b"\\\n", b" ").splitlines(), 1):
        word, *rest = line.split() or [b""]
        if word == b"v":
            if len(rest) < 3:
                raise MeshError(f"line {number}: a corner has three numbers")
            corners += rest[:3]
        elif word == b"f":
            used += [_corner(one, len(corners) // 3, number) for one in rest]
            ends.append(len(used))
    places = numbers(b" ".join(corners), "v").reshape(-1, 3)
    return Triangles(places, fans(np.array(used, dtype=np.int64), np.array(ends, dtype=np.int64)))


def _corner(text: bytes, known: int, line: int) -> int:
    """The number of a corner from 0 on, of `7`, `7/1`, `7//3` or `-1`, which is the last one so far."""
    first = text.split(b"/")[0]
    if not first.removeprefix(b"-").isdigit() or len(first) > 12 or int(first) == 0:
        raise MeshError(f"line {line}: a face names its corners by numbers from 1 on")
    value = int(first)
    return value - 1 if value > 0 else known + value
