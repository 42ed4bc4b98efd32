"""The lanes that share a programme, and the memory in which they solve it.

On a GPU they are a warp, and the memory is shared among them; on a CPU there is one, and the memory is a row of an
array.
"""

from functools import cache
from typing import Any

import warp as wp

LANES = 32  # of a GPU's warp, and columns of the tables of `Columns`


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
__syncwarp();
#endif
"""
)
def synchronize(): ...  # the lanes of a programme: what one has written, all read


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
for (int away = 16; away > 0; away >>= 1) value += __shfl_xor_sync(0xffffffffu, value, away);
#endif
return value;
"""
)
def sum_of_lanes(value: wp.float64) -> wp.float64: ...  # the same bits in all of them


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
for (int away = 16; away > 0; away >>= 1) value = max(value, __shfl_xor_sync(0xffffffffu, value, away));
#endif
return value;
"""
)
def max_of_lanes(value: wp.float64) -> wp.float64: ...


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
return rsqrt(value);
#else
return 1.0 / sqrt(value);
#endif
"""
)
def inverse_root(value: wp.float64) -> wp.float64: ...


@cache
def program_memory(doubles: int) -> Any:
    """A Warp function (CPU buffer) -> memory of a programme of so many numbers of 8 bytes."""
    snippet = f"""
#if defined(__CUDA_ARCH__)
__shared__ double warpmuscle_program[{doubles}];
return wp::array_t<double>(warpmuscle_program, {doubles});
#else
return buffer;
#endif
"""

    @wp.func_native(snippet=snippet)
    def memory(buffer: wp.array[wp.float64]) -> wp.array[wp.float64]: ...

    return memory


@wp.func_native(snippet="return wp::array_t<double>(memory.data + first, count);")
def doubles_at(memory: wp.array[wp.float64], first: int, count: int) -> wp.array[wp.float64]: ...


@wp.func_native(snippet="return wp::array_t<float>(reinterpret_cast<float*>(memory.data + first), count);")
def floats_at(memory: wp.array[wp.float64], first: int, count: int) -> wp.array[float]: ...
