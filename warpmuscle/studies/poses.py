"""Poses of a scene as coordinates, without a simulation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.model.build import motion_of, start_of
from warpmuscle.model.prescribed_motion import coordinate_numbers, moved
from warpmuscle.model.structure import structure_of
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology


def initial_coordinates(scene: Scene) -> Floats:
    """Coordinates (C,) of a scene's initial state, m, rad and unit quaternions, in the order of recordings."""
    plain = at_start(scene)
    return np.asarray(start_of(plain, topology(plain.character)).coordinates[0])


def prescribed_coordinates(scene: Scene, times: ArrayLike) -> Floats:
    """Coordinates (T, C) of a scene at times (T,), s, as its motion prescribes; others stay as at the start."""
    plain = at_start(scene)
    structure, chosen = structure_of(plain), np.asarray(times, dtype=np.float64)
    curves, moving = motion_of(plain, structure), structure.kinematic
    found = np.tile(initial_coordinates(plain), (len(chosen), 1))
    if moving.names:
        found[:, coordinate_numbers(moving)] = [moved(moving, curves, time).coordinates[0] for time in chosen]
    return found
