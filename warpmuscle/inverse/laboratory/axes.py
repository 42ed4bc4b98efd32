"""Which axes of a C3D file point up and forward: by its force plates and points, else as on a screen."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SignalError
from warpmuscle.inverse.laboratory.wrench import plate_axes
from warpmuscle.markers.arm import AXES
from warpmuscle.synergy.c3d import C3dRoom, read_room

LEVEL = 0.9  # cosine of the angle between a plate's normal and an axis, from which on it is that axis
WALKED = 0.1  # of the extent of all points, by which a body walks at least


def axes_of_c3d(path: Path, up: str | None = None, forward: str | None = None) -> tuple[str, str]:
    """Axes of a file that point up and forward, such as `z` and `-x`; those that are given stay.

    Raises:
        SignalError: see `read_c3d`; or an axis is none, or both are the same one.
    """
    room = None if up is not None and forward is not None else read_room(path)
    up = up or _up(room)
    forward = forward or _forward(room, up)
    check_axes(up, forward)
    return up, forward


def check_axes(up: str, forward: str) -> None:
    """Raise SignalError if an axis is none, or both are the same one."""
    for word, axis in (("up", up), ("forward", forward)):
        if axis not in AXES:
            raise SignalError(f"{word}: axis {axis!r} is none of x, y, z, -x, -y, -z")
    if AXES[up] == AXES[forward]:
        raise SignalError(f"up and forward must be two axes, not {up!r} and {forward!r}")


def to_ground(up: str, forward: str) -> Floats:
    """Ground axes x forward, y up and z to the right, as rows (3, 3) in axes of a file."""
    above, ahead = ((-1.0 if name[0] == "-" else 1.0) * np.eye(3)[AXES[name]] for name in (up, forward))
    return np.stack([ahead, above, np.cross(ahead, above)])


def _up(room: C3dRoom | None) -> str:
    """Where plates lie level, the side of them that points are on; else up on the screen, else y."""
    if room is None:
        return "y"
    normals = np.array([plate_axes(corners)[2] for corners in room.corners])
    level = np.abs(normals).max(axis=1) > LEVEL if len(normals) else np.zeros(0, bool)
    if level.any() and len(numbers := np.unique(np.argmax(np.abs(normals[level]), axis=1))) == 1:
        axis = int(numbers[0])
        heights = room.positions[..., axis]
        if np.isfinite(heights).any():
            above = np.nanmedian(heights) >= np.mean(room.corners[level][..., axis])
            return ("" if above else "-") + "xyz"[axis]
    return room.screen[1] if room.screen[1] in AXES else "y"


def _forward(room: C3dRoom | None, up: str) -> str:
    """The level axis along which points walk most; else that to the right on the screen, else x."""
    axis = AXES.get(up, 1)
    level = [other for other in range(3) if other != axis]
    if room is not None:
        walked, extent = _walked(room.positions, axis, -1.0 if up[0] == "-" else 1.0)
        most = int(np.argmax(np.abs(walked[level])))
        if extent > 0.0 and abs(walked[level][most]) > WALKED * extent:
            return ("-" if walked[level][most] < 0.0 else "") + "xyz"[level[most]]
        if AXES.get(room.screen[0]) in level:
            return room.screen[0]
    return "xyz"[level[0]]


def _walked(positions: Floats, axis: int, sign: float) -> tuple[Floats, float]:
    """How far all points move past the lowest one (3,), which stands on the floor or a belt; and their extent."""
    before, after = positions[:-1], positions[1:]
    moved = after - before
    seen = np.asarray(np.isfinite(moved).all(axis=2))
    rows = np.flatnonzero(seen.sum(axis=1) > 1)
    if not len(rows):
        return np.zeros(3), 0.0
    moved, seen = np.where(seen[..., None], moved, 0.0)[rows], seen[rows]
    heights = np.where(seen, sign * (before + after)[rows, :, axis], np.inf)
    low = moved[np.arange(len(rows)), np.argmin(heights, axis=1)]
    mean = moved.sum(axis=1) / seen.sum(axis=1)[:, None]
    body = before[rows[0]][seen[0]]
    return (mean - low).sum(axis=0), float(np.ptp(body, axis=0).max())
