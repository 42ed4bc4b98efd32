"""Arrays of others - PyTorch, JAX, CuPy, NumPy - as Warp arrays, without a copy where that is possible."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.core.errors import RolloutError


def rows_of(values: Any, width: int, instances: int, device: Any, what: str, numbers: bool = False) -> wp.array:
    """An array of numbers, (1 or instances, width), as one of the device.

    It is the same memory if the values are a Warp array, or anything with `__dlpack__`, of float32 on the device, or a
    NumPy array of float32 and the device the CPU; otherwise a copy.

    Args:
        numbers: whether none may be NaN, on a CPU; a GPU is not waited for.

    Raises:
        RolloutError: another shape, nothing that could be taken for numbers, or NaN.
    """
    array = _taken(values, device, what)
    if array.ndim != 2 or array.shape not in ((1, width), (instances, width)):
        raise RolloutError(f"{what} have shape {tuple(array.shape)}; this rollout takes (1 or {instances}, {width})")
    if numbers and array.device.is_cpu and (unknown := np.isnan(array.numpy())).any():
        row, column = np.argwhere(unknown)[0]
        raise RolloutError(f"{what} hold NaN in row {row}, column {column}")
    return array


def mask_of(values: Any, instances: int) -> NDArray[np.bool_]:
    """A mask (instances,) of bool, on the host.

    Raises:
        RolloutError: another shape or type.
    """
    mask = host_array(values, "the mask")
    if mask.shape != (instances,) or mask.dtype != np.bool_:
        raise RolloutError(f"a mask takes ({instances},) of bool, not {mask.shape} of {mask.dtype}")
    return mask


def is_array(values: Any) -> bool:
    """Whether something is an array of one dimension or more, or a list, and no number."""
    listed = isinstance(values, list | tuple) or hasattr(values, "__array__") or hasattr(values, "__dlpack__")
    return isinstance(values, wp.array) or (listed and not isinstance(values, np.generic))


def host_array(values: Any, what: str) -> NDArray[Any]:
    """Any array as one of NumPy."""
    if isinstance(values, wp.array):
        return np.asarray(values.numpy())
    plain = _detached(values)
    try:
        if _is_foreign(plain) and plain.__dlpack_device__()[0] != 1:  # not in the memory of the CPU
            return np.asarray(wp.from_dlpack(plain).numpy())
        return np.asarray(plain)
    except (TypeError, ValueError, RuntimeError, BufferError, OverflowError) as error:
        raise RolloutError(f"{what} cannot be taken from a {type(values).__name__}: {_line(error)}") from error


def _taken(values: Any, device: Any, what: str) -> wp.array:
    plain = _detached(values)
    try:
        if isinstance(plain, wp.array):
            array = plain
        elif _is_foreign(plain):
            array = wp.from_dlpack(plain)
        else:
            return wp.array(np.asarray(plain, dtype=np.float32), dtype=float, device=device, copy=False)
        if array.dtype is not wp.float32:
            return wp.array(array.numpy().astype(np.float32), dtype=float, device=device)
        return array if array.device == device else wp.clone(array, device=device)
    except (TypeError, ValueError, RuntimeError, BufferError, OverflowError) as error:
        raise RolloutError(f"{what} cannot be taken from a {type(values).__name__}: {_line(error)}") from error


def _is_foreign(values: Any) -> bool:
    return hasattr(values, "__dlpack__") and not isinstance(values, np.ndarray | np.generic)


def _detached(values: Any) -> Any:
    """A tensor without its gradient, which others cannot have."""
    return values.detach() if hasattr(values, "detach") else values


def _line(error: Exception) -> str:
    return " ".join(str(error).split())
