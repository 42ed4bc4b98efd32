"""Nested numbers of a scene as NumPy arrays: one row for all instances, or one row an instance."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats


def rows(nested: Any) -> Floats:
    """Nested lists of numbers as (rows, ...): numbers are floats, or (n,) arrays with one value an instance.

    rows is 1 if all are floats, n otherwise.
    """
    alike = _alike(nested)
    if alike is not None:
        return alike
    leaves: list[Any] = []
    shape = _shape(nested, leaves)
    count = max((len(leaf) for leaf in leaves if isinstance(leaf, np.ndarray)), default=1)
    table = np.empty((count, len(leaves)))
    for i, leaf in enumerate(leaves):
        table[:, i] = leaf
    return table.reshape(count, *shape)


def _alike(nested: Any) -> Floats | None:
    """The same where all are floats, or all are arrays, as nearly all of a scene is; else None."""
    depth, first = 0, nested
    while isinstance(first, (list, tuple)) and first:
        depth, first = depth + 1, first[0]
    depth += isinstance(first, (list, tuple))  # an empty one
    try:
        table = np.array(nested, dtype=np.float64)
    except ValueError:  # some of them are arrays
        return None
    if table.ndim == depth:
        return table[None]
    return np.ascontiguousarray(np.moveaxis(table, -1, 0)) if table.ndim == depth + 1 else None


def is_number(leaf: Any) -> bool:
    """Whether this is a number as such, and neither true nor false."""
    return isinstance(leaf, int | float | np.number) and not isinstance(leaf, bool)


def first_row(nested: Any) -> Floats:
    """The same of the first instance alone: nested lists of numbers, or of (n,) arrays, as an array of their shape."""
    return np.asarray(rows(nested)[0])


def first_number(number: Any) -> float:
    """A number of the first instance: a float, or the first of an array."""
    return float(np.asarray(number).flat[0])


def _shape(nested: Any, leaves: list[Any]) -> tuple[int, ...]:
    if not isinstance(nested, (list, tuple)):
        leaves.append(nested)
        return ()
    shapes = [_shape(member, leaves) for member in nested]
    return (len(nested), *(shapes[0] if shapes else ()))


def orthogonal(v: Floats, axis: Floats) -> Floats:
    """The part of vectors v (..., 3) across unit axes, with unit length."""
    across = v - np.sum(v * axis, axis=-1, keepdims=True) * axis
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    return np.asarray(across / np.where(length > 1e-9, length, 1.0))
