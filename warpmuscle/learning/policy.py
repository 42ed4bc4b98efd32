"""A learnt policy that says how to act, by NumPy or on a device; PyTorch is not needed."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import RolloutError
from warpmuscle.kernels.learning.policy import clip_noise, linear, normalize
from warpmuscle.results.learned import ClippedNoise, PolicyTable, check_policy


def actions_of(policy: PolicyTable, observation: Floats, shift: Floats | float = 0.0) -> Floats:
    """Actions (n, A) for observations (n, O), float32.

    Args:
        shift: (n, A), or for all, added to what the last layer says.

    Raises:
        RolloutError: the observations have another shape.
    """
    values = np.asarray(observation, dtype=np.float32)
    if values.ndim != 2 or values.shape[1] != len(policy.observation):
        raise RolloutError(f"observations have shape {values.shape}; the policy takes (n, {len(policy.observation)})")
    values = np.clip((values - policy.mean) / policy.deviation, -policy.widest, policy.widest)
    for number, layer in enumerate(policy.layers):
        values = np.asarray(values @ layer.weight.T + layer.bias)
        if number < len(policy.layers) - 1:
            values = np.where(values > 0.0, values, np.expm1(np.minimum(values, 0.0)))
    values = values + shift
    if policy.noise is not None:
        values = clipped_mean(values, policy.noise)
    return np.asarray(values, dtype=np.float32)


def clipped_mean(mean: Floats, noise: ClippedNoise) -> Floats:
    """Means (n, A) of clip(x, low, high) over x of normal distributions with these means."""
    from scipy.special import ndtr  # takes a third of a second

    def mean_above(z: Floats) -> Floats:  # of max(z + x, 0)
        return np.asarray(z * ndtr(z) + np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi))

    width = noise.deviation
    return np.asarray(mean + width * (mean_above((noise.low - mean) / width) - mean_above((mean - noise.high) / width)))


class DevicePolicy:
    """A policy on a device, for n instances: the same observation gives the same bits wherever in whatever batch.

    Attributes:
        action: (n, A) on the device, of the last `act`.
    """

    def __init__(self, policy: PolicyTable, instances: int, device: Any, action: wp.array | None = None) -> None:
        """Put the policy on a device.

        Args:
            action: (instances, A) where actions are to be put; by default a new array.

        Raises:
            ValueError: the policy is not sound.
        """
        check_policy(policy)
        self._widest, self._device = float(policy.widest), wp.get_device(device)

        def on_device(values: Floats) -> wp.array:
            return wp.array(np.ascontiguousarray(values, dtype=np.float32), dtype=float, device=self._device)

        self._mean, self._deviation = on_device(policy.mean), on_device(policy.deviation)
        self._layers = [(on_device(layer.weight.T), on_device(layer.bias)) for layer in policy.layers]
        self._noise = policy.noise
        self._spread = None if policy.noise is None else on_device(policy.noise.deviation)
        sizes = [len(policy.observation), *(len(layer.bias) for layer in policy.layers)]
        self._values = [wp.zeros((instances, size), dtype=float, device=self._device) for size in sizes]
        if action is not None:
            self._values[-1] = action
        self.action = self._values[-1]

    def act(self, observation: wp.array) -> wp.array:
        """Actions (n, A) for observations (n, O), both float32 arrays of the device; the same array every time."""
        values = self._values
        inputs = [observation, self._mean, self._deviation, self._widest]
        wp.launch(normalize, values[0].shape, inputs, [values[0]], device=self._device)
        for number, (weight, bias) in enumerate(self._layers):
            hidden = number < len(self._layers) - 1
            inputs = [values[number], weight, bias, hidden]
            wp.launch(linear, values[number + 1].shape, inputs, [values[number + 1]], device=self._device)
        if self._noise is not None:
            inputs = [self._spread, float(self._noise.low), float(self._noise.high)]
            wp.launch(clip_noise, self.action.shape, inputs, [self.action], device=self._device)
        return self.action
