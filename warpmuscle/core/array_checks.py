"""Arrays that came from a file are of the shape and the kind that they should be, and hold no absurd numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

HUGE = 1.0e150  # whose square is a number
LARGEST_INDEX = 2**31 - 1


def check_integers(name: str, array: Any, shape: tuple[int, ...], low: int = 0, high: int = LARGEST_INDEX) -> None:
    """ValueError unless an array has this shape and whole numbers from low to high."""
    check_numbers(name, array, shape, low, high, kinds="iu")


def check_numbers(
    name: str, array: Any, shape: tuple[int, ...], low: float = -HUGE, high: float = HUGE, gaps: bool = False,
    kinds: str = "iuf",
) -> None:  # fmt: skip
    """ValueError unless an array has this shape and numbers from low to high; with gaps, some may be not a number."""
    found = np.asarray(array)
    if found.dtype.kind not in kinds or found.dtype.itemsize > 8:
        what = "whole numbers" if kinds == "iu" else "numbers"
        raise ValueError(f"{name} holds no {what}, but values of type {found.dtype}")
    if found.shape != shape:
        raise ValueError(f"{name} has shape {found.shape}, not {shape}")
    values = found[~np.isnan(found)] if gaps else found
    if not values.size:
        return
    least, greatest = values.min().item(), values.max().item()  # in double precision, which holds the bounds
    if not (low <= least and greatest <= high):
        wrong = greatest if low <= least else least
        raise ValueError(f"{name} holds {wrong:g}, and should lie between {low:g} and {high:g}")
