"""Rows of small matrices that stay in a lane's registers, although which row is meant is known only as a step runs.

The compiler puts what is indexed by a number that it does not know into memory of the lane's own, which with shared
memory in full use has no room in the first cache. Here every row is looked at, and the one that is meant is taken.
"""

from functools import cache
from typing import Any, NamedTuple

import warp as wp

TAKE = """
#if defined(__CUDA_ARCH__)
#pragma unroll
for (int i = 0; i < {count}; ++i)
    if (i == k) {{ {each} }}
#else
const int i = k;
{each}
#endif
"""


class Rows(NamedTuple):
    """Warp functions on vectors of so many whole or other numbers."""

    number: Any  # (vector of whole numbers, k) -> int
    with_number: Any  # (vector of whole numbers, k, int) -> vector
    length: Any  # (vector, k) -> float
    with_length: Any  # (vector, k, float) -> vector


@cache
def rows_of(count: int) -> Rows:
    """The functions for vectors of so many rows."""
    numbers, lengths = (wp.types.vector(length=count, dtype=kind) for kind in (int, float))

    def snippet(each: str, result: str) -> str:
        return f"auto found = {result};{TAKE.format(count=count, each=each)}return found;"

    @wp.func_native(snippet=snippet("found = v[i];", "0"))
    def number(v: numbers, k: int) -> int: ...

    @wp.func_native(snippet=snippet("found[i] = value;", "v"))
    def with_number(v: numbers, k: int, value: int) -> numbers: ...

    @wp.func_native(snippet=snippet("found = v[i];", "0.0f"))
    def length(v: lengths, k: int) -> float: ...

    @wp.func_native(snippet=snippet("found[i] = value;", "v"))
    def with_length(v: lengths, k: int, value: float) -> lengths: ...

    return Rows(number, with_number, length, with_length)


class RowsOf(NamedTuple):
    """Warp functions on the rows of a field of a structure: of three numbers each, or of one."""

    get: Any  # (structure, k) -> vec3 or float
    put: Any  # (structure, k, value)
    add: Any  # (structure, k, vec3)


@cache
def rows_in(struct: Any, field: str, count: int, few: int) -> RowsOf:
    """The functions for a matrix of so many rows, or a vector, that is a field of a structure.

    Of more rows than a few, they are found by their number in memory of the lane's own, in place: that needs a first
    cache with room, and neither registers nor the instructions that look at all rows.
    """
    rows = wp.types.type_size(struct.vars[field].type) > count
    one, axes = (wp.vec3, "for (int axis = 0; axis < 3; ++axis) ") if rows else (float, "")
    at, own = (f"s.{field}.data[i][axis]", "[axis]") if rows else (f"s.{field}[i]", "")
    take = "const int i = k; {each}" if count > few else TAKE

    def snippet(each: str) -> str:
        return take.format(count=count, each=f"{axes}{each}")

    found = "wp::vec3 found;" if rows else "float found = 0.0f;"

    @wp.func_native(snippet=f"{found} {snippet(f'found{own} = {at};')} return found;")
    def get(s: wp.ref[struct], k: int) -> one: ...

    @wp.func_native(snippet=snippet(f"{at} = value{own};"))
    def put(s: wp.ref[struct], k: int, value: one): ...

    @wp.func_native(snippet=snippet(f"{at} += value{own};"))
    def add(s: wp.ref[struct], k: int, value: one): ...

    return RowsOf(get, put, add)
