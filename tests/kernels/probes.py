"""Warp functions evaluated on NumPy arrays, element by element, and rotations in float64 to compare them with."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arrays import structs_to_device


def evaluate(function: wp.Function, *values: Any) -> Any:
    """Results (n, ...) of a Warp function on the CPU in float64, a tuple if it returns several.

    Args:
        function: of plain values.
        values: one an argument, (n, ...) arrays or single values that all n evaluations share.
    """
    types = list(function.input_types.values())
    singles = [len(getattr(kind, "_shape_", ())) for kind in types]  # dimensions of one value
    arrays = [np.asarray(value) for value in values]
    count = max((len(array) for array, single in zip(arrays, singles, strict=True) if array.ndim > single), default=1)
    given = []
    for array, single, kind in zip(arrays, singles, types, strict=True):
        full = array if array.ndim > single else np.broadcast_to(array, (count, *array.shape))
        given.append(wp.array(np.ascontiguousarray(full, np.int32 if kind is int else np.float32), kind, device="cpu"))
    return wp.map(function, *given).numpy().astype(np.float64)


def vectors(count: int, seed: int = 0, scale: float = 1.0) -> np.ndarray:
    """Normal random vectors (count, 3)."""
    return np.random.default_rng(seed).normal(size=(count, 3)) * scale


def units(count: int, seed: int = 0, size: int = 3) -> np.ndarray:
    """Random unit vectors, or with size 4 unit quaternions."""
    v = np.random.default_rng(seed).normal(size=(count, size))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def matrix(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4) xyzw: R = 1 + 2 w [v]x + 2 [v]x [v]x."""
    skew = cross_matrix(quaternion[..., :3])
    return np.eye(3) + 2.0 * quaternion[..., 3, None, None] * skew + 2.0 * skew @ skew


def cross_matrix(v: np.ndarray) -> np.ndarray:
    """[v]x (n, 3, 3) of vectors (n, 3)."""
    return np.cross(v[..., None, :], np.eye(3)).swapaxes(-1, -2)


def turn_about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) xyzw of turns by angles (n,) about unit axes (n, 3) or (3,)."""
    half = 0.5 * np.asarray(angle, dtype=float)[..., None]
    return np.concatenate([np.sin(half) * axis, np.cos(half)], axis=-1)


def filled(struct: Any, **fields: Any) -> Any:
    """A Warp structure on the CPU with these fields; the others are zero or empty.

    Args:
        fields: numbers; arrays; arrays of structures as dictionaries of columns, each of the array's shape.
    """
    one = struct()
    for name, value in fields.items():
        kind = struct.vars[name].type
        if not hasattr(kind, "ndim"):
            setattr(one, name, value)
        elif isinstance(value, dict):
            setattr(one, name, structs_to_device(kind.dtype, value, "cpu"))
        else:
            given = (
                value if isinstance(value, wp.array) else wp.array(np.asarray(value), dtype=kind.dtype, device="cpu")
            )
            setattr(one, name, given)
    return one
