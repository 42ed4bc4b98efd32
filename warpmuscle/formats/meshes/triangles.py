"""Corners and triangles, and polygons as triangles; numbers only."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import Error
from warpmuscle.core.limits import check_size


class MeshError(Error):
    """A file of triangles is damaged; the message does not name the file."""


class Triangles(NamedTuple):
    """A surface."""

    corners: Floats  # (V, 3)
    faces: Integers  # (F, 3)


def fans(connectivity: Integers, ends: Integers) -> Integers:
    """Polygons as triangles (F, 3) from their first corner on.

    Args:
        connectivity: corners of all polygons in order. ends: of each, where the next one begins.

    Raises:
        MeshError: the polygons end before they begin, or beyond the corners.
    """
    starts = np.concatenate([[0], ends[:-1]]) if len(ends) else ends
    counts = ends - starts
    if len(ends) and (counts.min() < 0 or ends[-1] > len(connectivity)):
        raise MeshError("its polygons end where there are no corners")
    made = np.maximum(counts - 2, 0)
    check_size("triangles", int(made.sum()), MeshError)
    start = np.repeat(starts, made)
    step = np.arange(len(start)) - np.repeat(np.cumsum(made) - made, made)
    return np.stack([connectivity[start], connectivity[start + step + 1], connectivity[start + step + 2]], axis=1)


def numbers(text: bytes, what: str) -> Floats:
    """Numbers between blanks; raises MeshError for anything else."""
    try:
        return np.array(text.split(), dtype=np.float64)
    except ValueError:
        raise MeshError(f"{what}: something is not a number") from None


def as_integers(values: Floats, what: str) -> Integers:
    """The same as whole numbers; raises MeshError for others."""
    if not np.all(np.abs(values) < 2.0**53):
        raise MeshError(f"{what}: something is not a whole number")
    return values.astype(np.int64)
