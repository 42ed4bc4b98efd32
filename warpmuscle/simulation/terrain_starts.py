"""Starts over ground that is not flat: roots are raised by what rises below them."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.kernels import structs
from warpmuscle.model.joints import root_number
from warpmuscle.scene import Scene


class TerrainStarts:
    """Raises the roots of a batch where its ground is not flat; else it does nothing.

    Attributes:
        applies: whether there is anything to do.
    """

    def __init__(self, scene: Scene, instances: int, device: Any) -> None:
        """Make room for a height an instance."""
        terrain = scene.ground.terrain
        self.applies = terrain is not None
        self._clearing = 0.0 if terrain is None else terrain.clearing
        self._root, self._device, count = root_number(scene.character), device, instances if self.applies else 0
        self._rise = wp.zeros(count, dtype=float, device=device)
        self._all = wp.full(count, True, dtype=bool, device=device)

    def put(self, model: structs.Model, state: structs.State, mask: Any = None) -> None:
        """Raise the roots of the instances of a mask, by default all, which stand as over the plane.

        Args:
            mask: (instances,) on the device, or of NumPy.
        """
        if not self.applies:
            return
        if isinstance(mask, np.ndarray):
            mask = wp.array(mask, dtype=bool, device=self._device)
        self._find(model, state)
        from warpmuscle.kernels.contact import terrain_starts

        inputs = [self._all if mask is None else mask, self._root, self._rise, state]
        wp.launch(terrain_starts.raise_roots, len(self._rise), inputs, device=self._device)

    def rise(self, model: structs.Model, state: structs.State) -> Floats:
        """By how much (instances,) they would be raised where they stand, m."""
        if not self.applies:
            return np.zeros(len(state.step))
        self._find(model, state)
        return np.asarray(self._rise.numpy(), dtype=np.float64)

    def _find(self, model: structs.Model, state: structs.State) -> None:
        from warpmuscle.kernels.contact import terrain_starts  # with kernels, whose functions Warp parses at once

        inputs = [model, state, self._root, self._clearing, self._rise]
        wp.launch(terrain_starts.highest_rise, len(self._rise), inputs, device=self._device)
