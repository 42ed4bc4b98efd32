"""What instances of a batch are given beside parameters: excitations, motions, and where they start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.arrays import Floats, to_device
from warpmuscle.errors import RolloutError
from warpmuscle.kernels import structs
from warpmuscle.motion import Curves, check_knots


@dataclass
class Inputs:
    """What a batch has been given in place of what its scene says; None where the scene counts."""

    excitations: dict[str, wp.array] | None = None  # by field of `kernels.structs.Muscles`
    motion: Curves | None = None
    coordinates: Floats | None = None  # (1 or instances, coordinates)
    speeds: Floats | None = None  # (1 or instances, speeds)
    activation: Floats | None = None  # (1 or instances, simulated muscles)

    def put(self, model: structs.Model) -> None:
        """Let a model have the excitations."""
        for field, array in (self.excitations or {}).items():
            setattr(model.muscles, field, array)


def excitation_arrays(
    time: ArrayLike, values: ArrayLike, muscles: int, chosen: list[int], instances: int, device: Any
) -> dict[str, wp.array]:
    """Excitations over time, straight between knots, by field of `kernels.structs.Muscles`.

    Args:
        time: (K,) s. values: (1 or instances, muscles, K). chosen: numbers of the muscles that are simulated.

    Raises:
        RolloutError: wrong shapes, numbers that are not finite, or times that do not increase.
    """
    t, v = np.asarray(time, dtype=np.float64), np.asarray(values)
    if t.ndim != 1 or not len(t) or v.shape not in ((1, muscles, len(t)), (instances, muscles, len(t))):
        raise RolloutError(
            f"excitations of {muscles} muscles take times (K,) and values (1 or {instances}, {muscles}, K), "
            f"not {t.shape} and {v.shape}"
        )
    check_knots(t, v, "excitations")
    own = np.clip(v if chosen == list(range(muscles)) else v[:, chosen], 0.0, 1.0)
    count = len(chosen)
    return {
        "knot_start": to_device(np.arange(count + 1) * len(t), int, device),
        "knot_time": to_device(np.tile(t, count)[None], float, device),
        "knot_value": to_device(own.reshape(len(v), -1), float, device),
        "period": to_device(np.zeros((1, max(count, 1))), float, device),
    }


def start_values(values: ArrayLike, count: int, instances: int, what: str) -> Floats:
    """Values to start from, (1 or instances, count).

    Raises:
        RolloutError: another shape, or a number that is not finite.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.shape not in ((1, count), (instances, count)):
        raise RolloutError(f"{what} have shape {array.shape}; this rollout takes (1 or {instances}, {count})")
    if not np.isfinite(array).all():
        raise RolloutError(f"a number of the {what} is not finite")
    return array
