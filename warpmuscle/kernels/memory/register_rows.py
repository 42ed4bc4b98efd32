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
    """Warp functions on matrices of so many rows of three numbers, and on vectors of as many whole or other numbers."""

    row: Any  # (matrix, k) -> vec3
    with_row: Any  # (matrix, k, vec3) -> matrix
    with_sum: Any  # (matrix, k, vec3) -> matrix with the vector added to row k
    number: Any  # (vector of whole numbers, k) -> int
    with_number: Any  # (vector of whole numbers, k, int) -> vector
    length: Any  # (vector, k) -> float
    with_length: Any  # (vector, k, float) -> vector


@cache
def rows_of(count: int) -> Rows:
    """The functions for matrices and vectors of so many rows."""
    matrix = wp.types.matrix(shape=(count, 3), dtype=float)
    numbers, lengths = (wp.types.vector(length=count, dtype=kind) for kind in (int, float))

    def snippet(each: str, result: str) -> str:
        return f"auto found = {result};{TAKE.format(count=count, each=each)}return found;"

    each_axis = "for (int axis = 0; axis < 3; ++axis)"

    @wp.func_native(snippet=snippet(f"{each_axis} found[axis] = m.data[i][axis];", "wp::vec3()"))
    def row(m: matrix, k: int) -> wp.vec3: ...

    @wp.func_native(snippet=snippet(f"{each_axis} found.data[i][axis] = value[axis];", "m"))
    def with_row(m: matrix, k: int, value: wp.vec3) -> matrix: ...

    @wp.func_native(snippet=snippet(f"{each_axis} found.data[i][axis] += value[axis];", "m"))
    def with_sum(m: matrix, k: int, value: wp.vec3) -> matrix: ...

    @wp.func_native(snippet=snippet("found = v[i];", "0"))
    def number(v: numbers, k: int) -> int: ...

    @wp.func_native(snippet=snippet("found[i] = value;", "v"))
    def with_number(v: numbers, k: int, value: int) -> numbers: ...

    @wp.func_native(snippet=snippet("found = v[i];", "0.0f"))
    def length(v: lengths, k: int) -> float: ...

    @wp.func_native(snippet=snippet("found[i] = value;", "v"))
    def with_length(v: lengths, k: int, value: float) -> lengths: ...

    return Rows(row, with_row, with_sum, number, with_number, length, with_length)
