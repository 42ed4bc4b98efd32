"""Poses of a scene as coordinates."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.model.build import start_of
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology


def initial_coordinates(scene: Scene) -> Floats:
    """Coordinates (C,) of a scene's initial state, m, rad and unit quaternions, in the order of recordings."""
    plain = at_start(scene)
    return np.asarray(start_of(plain, topology(plain.character)).coordinates[0])
