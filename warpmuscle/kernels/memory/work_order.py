"""The order in which warps take muscles: those that took longest first, so that no warp ends much later than others.

How long a muscle takes depends on the surfaces that it touches, on the places where it does, and on the GPU. So it is
measured as muscles are simulated, and the order follows. No result depends on it. Muscles that lanes of one warp take
side by side wait for one another, and so have one time: they stay together, as alike as they were put.
"""

import warp as wp


@wp.func
def time_of(group: int, size: int, took: wp.array[int], order: wp.array[int]) -> int:
    """Cycles that the slowest muscle of a group took."""
    longest = wp.int32(0)
    for place in range(group * size, (group + 1) * size):
        longest = wp.max(longest, took[order[place]])
    return longest


@wp.kernel(enable_backward=False)
def rank_muscles(size: int, took: wp.array[int], order: wp.array[int], ranked: wp.array[int]):
    """Put a muscle, with its group of so many, behind all groups that took longer; the last one, if not full, stays."""
    place = wp.tid()
    groups = order.shape[0] // size
    group = place // size
    rank = int(group)
    if group < groups:
        own = time_of(group, size, took, order)
        before = wp.int32(0)
        for other in range(groups):
            time = time_of(other, size, took, order)
            if time > own or (time == own and other < group):
                before += 1
        rank = before
    ranked[rank * size + place % size] = order[place]
