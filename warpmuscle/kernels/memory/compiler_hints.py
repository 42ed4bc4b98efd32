"""Tells the compiler how the arrays of a structure lie in memory.

Else it takes every stride as a number that it has to fetch and to multiply by, which is a tenth of what a step does on
a GPU.
"""

from collections.abc import Iterator
from functools import cache
from itertools import starmap
from math import gcd
from typing import Any

import warp as wp

ALIGNED = 16  # bytes, that a lane fetches at once at most


@cache
def known_rows_of(
    struct: Any, others: tuple[str, ...] = (), pairs: tuple[str, ...] = (), side_by_side: bool = False
) -> Any:
    """A Warp function (structure) that makes the strides of its arrays known to the compiler.

    Args:
        struct: the type of the structure, all of whose arrays have contiguous rows.
        others: but for these, by name, such as "actuation.effort".
        pairs: arrays of two numbers each, both of which a GPU then fetches at once.
        side_by_side: what is contiguous is the first axis instead, see `core.arrays.instance_zeros`.
    """
    whole = "auto whole = [](int i) { __builtin_assume(i >= 0); return i; };"
    lines = [whole, *_lines(struct, "s", {f"s.{name}" for name in others}, side_by_side)]
    aligned = {f"s.{name}": 8 for name in pairs} | dict(_records(struct, "s"))
    if aligned:
        lines += ["#if defined(__CUDA_ARCH__)", *starmap(_aligned, aligned.items()), "#endif", ""]
    snippet = "\n".join(lines)

    @wp.func_native(snippet=snippet)
    def know_rows(s: wp.ref[struct]): ...

    return know_rows


def _aligned(place: str, size: int) -> str:
    """What says that all elements of an array lie at multiples of so many bytes."""
    return f"{place}.data = (decltype({place}.data))__builtin_assume_aligned({place}.data, {size});"


def _records(struct: Any, path: str) -> Iterator[tuple[str, int]]:
    """Arrays of records of a multiple of 8 or 16 bytes, which the lane of a GPU fetches by as many at once."""
    for name, field in struct.vars.items():
        place = f"{path}.{name}"
        if hasattr(field.type, "ndim"):
            if hasattr(field.type.dtype, "vars"):
                size = gcd(wp.types.type_size_in_bytes(field.type.dtype), ALIGNED)
                if size > 4:
                    yield place, size
        elif hasattr(field.type, "vars"):
            yield from _records(field.type, place)


def _lines(struct: Any, path: str, others: set[str], side_by_side: bool) -> list[str]:
    """What says so of every array of a structure and of the structures in it."""
    lines = []
    for name, field in struct.vars.items():
        place = f"{path}.{name}"
        if hasattr(field.type, "ndim") and place not in others:
            axes = range(field.type.ndim)
            near = 0 if side_by_side else axes[-1]
            lines.append(f"{place}.strides[{near}] = sizeof(*{place}.data);")
            lines.extend(f"{place}.strides[{k}] = whole({place}.strides[{k}]);" for k in axes if k != near)
        elif hasattr(field.type, "vars"):
            lines.extend(_lines(field.type, place, others, side_by_side))
    return lines
