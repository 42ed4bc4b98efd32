"""From the channels of a force plate to the force and moment at its surface, by the kind of plate as C3D files tell it.

Kinds and their parameters are those of the C3D file format (c3d.org, `FORCE_PLATFORM:TYPE` and `ORIGIN`). Axes are the
plate's: x and y along its edges, z through its surface, mostly downwards.
"""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats

CHANNELS = {1: 6, 2: 6, 3: 8, 4: 6}  # by the number of the kind
CALIBRATED = 4  # kind whose channels are multiplied by a matrix


def surface_wrench(kind: int, signals: Floats, origin: Floats) -> tuple[Floats, Floats]:
    """Force (T, 3) N and moment (T, 3) N m about the centre of the working surface, in the plate's axes.

    Args:
        kind: one of `CHANNELS`. signals: (T, n) N, N m and m, of its channels: 1 has forces, the centre of pressure
            from the origin of the plate's axes and the moment about it, 2 and 4 have forces and moments, 3 the forces
            of four sensors: x of 1 and 2, x of 3 and 4, y of 1 and 4, y of 2 and 3, and z of each. origin: (3,) m, from
            the origin of these axes, below the surface, to its centre; of kind 3, half the distances between sensors
            and how far they are below it.
    """
    depth = abs(float(origin[2]))  # some programs write it without its sign
    if kind == 1:
        force, center = signals[:, :3], signals[:, 3:5] - origin[:2]
        arm = np.column_stack([center, np.zeros(len(center))])
        free = np.column_stack([np.zeros((len(center), 2)), signals[:, 5]])
        return force, np.cross(arm, force) + free
    if kind == 3:
        x12, x34, y14, y23, z1, z2, z3, z4 = signals.T
        a, b = abs(float(origin[0])), abs(float(origin[1]))
        force = np.column_stack([x12 + x34, y14 + y23, z1 + z2 + z3 + z4])
        moment = np.column_stack([b * (z1 + z2 - z3 - z4), a * (z2 + z3 - z1 - z4), b * (x34 - x12) + a * (y14 - y23)])
        return force, moment + np.cross(force, [0.0, 0.0, -depth])
    return signals[:, :3], signals[:, 3:6] + np.cross(signals[:, :3], [origin[0], origin[1], -depth])


def plate_axes(corners: Floats) -> Floats:
    """Axes of a plate as rows (3, 3), of corners (4, 3) at +x +y, -x +y, -x -y and +x -y of it; NaN of no rectangle."""
    first, second, third, fourth = corners
    along, across = first + fourth - second - third, first + second - third - fourth
    normal = np.cross(along, across)
    with np.errstate(invalid="ignore", divide="ignore"):
        x, z = (vector / np.linalg.norm(vector) for vector in (along, normal))
    return np.stack([x, np.cross(z, x), z])


def pressure_point(force: Floats, moment: Floats, least: float) -> Floats:
    """Centre of pressure (T, 2) m on the surface, from its centre.

    Where z of the force is small, it is that of the nearest time at which it is not.

    Args:
        force, moment: as `surface_wrench` has them. least: N, of z of the force.
    """
    loaded = np.flatnonzero(np.abs(force[:, 2]) > least)
    if not len(loaded):
        return np.zeros((len(force), 2))
    found = np.column_stack([-moment[loaded, 1], moment[loaded, 0]]) / force[loaded, 2:]
    after = np.minimum(np.searchsorted(loaded, np.arange(len(force))), len(loaded) - 1)
    before = np.maximum(after - 1, 0)
    rows = np.arange(len(force))
    nearer = np.abs(loaded[before] - rows) < np.abs(loaded[after] - rows)
    return found[np.where(nearer, before, after)]
