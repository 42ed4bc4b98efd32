"""Which lanes take which muscles, where muscles take different times."""

import warp as wp

from warpmuscle.kernels.functions import func


@func
def in_turn(k: int, lane: int, lanes: int, count: int) -> int:
    """Which of the muscles, by their work, a lane takes where it would take the k-th: there and back again."""
    first = k - lane
    turned = wp.min(first + lanes, count) - 1 - lane
    return wp.where((first // lanes) % 2 == 1 and first + lanes <= count, turned, k)


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
__shared__ int turn;
if (anew) {
    turn = 0;
    return 0;
}
const unsigned all = 0xffffffffu;
__syncwarp();
const int leader = __ffs(__ballot_sync(all, 1)) - 1;
int own = 0;
if ((threadIdx.x & 31) == leader)
    own = atomicAdd(&turn, 1);
return __shfl_sync(all, own, leader);
#else
return 0;
#endif
"""
)
def next_turn(anew: int) -> int:
    """Number of the group of muscles that a warp of a block takes next, the same on all its lanes.

    A warp that is done earlier takes more of them; no result depends on it, since no muscle does on another.

    Args:
        anew: 1: begin again; before the next turn is taken, there has to be a barrier.
    """
    ...
