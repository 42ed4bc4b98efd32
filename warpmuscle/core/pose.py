"""Poses on the host: quaternions, and joint orientations to and from joint coordinates, for whole batches at once.

Quaternions are (..., 4) arrays in the order x, y, z, w; float64 throughout.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats

Array = Floats


def cross(a: Array, b: Array) -> Array:
    """Cross products of vectors (..., 3): numpy.cross, bit for bit, in half its time."""
    ax, ay, az, bx, by, bz = (v[..., k] for v in (a, b) for k in range(3))
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def normalized(v: ArrayLike, least: float = 0.0) -> Array:
    """Vectors or quaternions of unit length, (..., k); those shorter than `least` are divided by it."""
    a = np.asarray(v, dtype=np.float64)
    return np.asarray(a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), least))


def multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """Hamilton product p q: the rotation q followed by the rotation p."""
    a, b = np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64)
    vector = a[..., 3:] * b[..., :3] + b[..., 3:] * a[..., :3] + cross(a[..., :3], b[..., :3])
    scalar = a[..., 3] * b[..., 3] - np.sum(a[..., :3] * b[..., :3], axis=-1)
    return np.concatenate([vector, scalar[..., None]], axis=-1)


def conjugate(q: ArrayLike) -> Array:
    """The inverse of a unit quaternion."""
    return np.asarray(np.asarray(q, dtype=np.float64) * np.array([-1.0, -1.0, -1.0, 1.0]))


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Vectors v (..., 3) rotated by unit quaternions q (..., 4)."""
    a, b = np.asarray(q, dtype=np.float64), np.asarray(v, dtype=np.float64)
    t = 2.0 * cross(a[..., :3], b)
    return b + a[..., 3:] * t + cross(a[..., :3], t)


def about(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Rotation by `angle` (rad, (...)) about unit vectors `axis` (..., 3)."""
    a, half = np.asarray(axis, dtype=np.float64), 0.5 * np.asarray(angle, dtype=np.float64)[..., None]
    shape = np.broadcast_shapes(a.shape[:-1], half.shape[:-1])
    return np.concatenate(
        [np.broadcast_to(np.sin(half) * a, (*shape, 3)), np.broadcast_to(np.cos(half), (*shape, 1))], -1
    )


def from_rotation_vector(vector: ArrayLike) -> Array:
    """Rotations by vectors (..., 3) along their axes, as long as their angles, rad."""
    v = np.asarray(vector, dtype=np.float64)
    half = 0.5 * np.linalg.norm(v, axis=-1, keepdims=True)
    return np.concatenate([v * 0.5 * np.sinc(half / np.pi), np.cos(half)], axis=-1)


def rotation_vector(q: ArrayLike) -> Array:
    """Vectors (..., 3) along the axes of rotations (..., 4), as long as their angles, rad, of half a turn at most."""
    turn = np.asarray(q, dtype=np.float64)
    turn = np.where(turn[..., 3:] < 0.0, -turn, turn)
    sine = np.linalg.norm(turn[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, turn[..., 3:])
    return np.asarray(turn[..., :3] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0))


def twist_angle(q: ArrayLike, axis: ArrayLike) -> Array:
    """Angle of a rotation about a unit axis, rad, within -pi..pi: the twist of its swing-twist decomposition."""
    a = np.asarray(q, dtype=np.float64)
    angle = 2.0 * np.arctan2(np.sum(a[..., :3] * np.asarray(axis), axis=-1), a[..., 3])
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def turned_to_heading(q: ArrayLike, heading: ArrayLike) -> Array:
    """Rotation about the vertical that gives orientations q (..., 4) the heading (rad)."""
    up = np.array([0.0, 1.0, 0.0])
    return about(up, np.asarray(heading) - twist_angle(q, up))


def unwrapped(angles: Array, breaks: ArrayLike = ()) -> Array:
    """Angles (n, ...), rad, that go on from row to row without jumps of a turn.

    Args:
        breaks: rows before which they need not, such as the first ones of recordings.
    """
    found = np.array(angles, dtype=np.float64)
    firsts = np.concatenate([[0], np.asarray(breaks, dtype=np.int64), [len(found)]])
    jumps = np.unique(np.argwhere(np.abs(np.diff(found, axis=0)) > np.pi)[:, 0]) + 1
    for part in np.unique(np.searchsorted(firsts, np.setdiff1d(jumps, firsts), side="right") - 1).tolist():
        inside = slice(firsts[part], firsts[part + 1])
        found[inside] = np.unwrap(found[inside], axis=0)
    return found


def euler_xyz(quaternion: Array, breaks: ArrayLike = ()) -> Array:
    """Angles (n, 3), rad, of turns about x, then the new y, then the new z axis: R = Rx Ry Rz.

    Args:
        quaternion: (n, 4) xyzw, of any length but 0. breaks: see `unwrapped`.
    """
    x, y, z, w = normalized(quaternion).T
    first = np.arctan2(2.0 * (x * w - y * z), 1.0 - 2.0 * (x * x + y * y))
    second = np.arcsin(np.clip(2.0 * (x * z + y * w), -1.0, 1.0))
    third = np.arctan2(2.0 * (z * w - x * y), 1.0 - 2.0 * (y * y + z * z))
    return unwrapped(np.stack([first, second, third], axis=-1), breaks)


def hinge_coordinates(q: Array, velocity: Array, axis: Array) -> tuple[Array, Array]:
    """Angle and rate (..., 1) of a hinge from relative orientation and angular velocity (parent axes)."""
    return twist_angle(q, axis)[..., None], np.sum(velocity * axis, axis=-1)[..., None]


def universal_coordinates(q: Array, velocity: Array, axis_a: Array, axis_b: Array) -> tuple[Array, Array]:
    """Angles and rates (..., 2) of a universal joint with q = rot(b, beta) rot(a, alpha), as alpha, beta."""
    turned_a = rotate(q, axis_a)
    turned_b = rotate(conjugate(q), axis_b)
    cosine = np.sum(np.asarray(axis_a) * axis_b, axis=-1)
    square = cosine * cosine
    beta = np.arctan2(np.sum(turned_a * np.cross(axis_b, axis_a), axis=-1), np.sum(turned_a * axis_a, axis=-1) - square)
    alpha = np.arctan2(
        -np.sum(turned_b * np.cross(axis_a, axis_b), axis=-1), np.sum(turned_b * axis_b, axis=-1) - square
    )
    along_a, along_b = np.sum(turned_a * velocity, axis=-1), np.sum(velocity * axis_b, axis=-1)
    rates = np.stack([along_a - cosine * along_b, along_b - cosine * along_a], axis=-1) / (1.0 - square)[..., None]
    return np.stack([alpha, beta], axis=-1), rates
