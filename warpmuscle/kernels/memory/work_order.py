"""The order in which warps take muscles: those that took longest first, so that no warp ends much later than others.

How long a muscle takes depends on the surfaces that it touches, on the places where it does, and on the GPU. So it is
measured as muscles are simulated, and the order follows. No result depends on it.
"""

import warp as wp


@wp.kernel(enable_backward=False)
def rank_muscles(took: wp.array[int], order: wp.array[int], rank: wp.array[int]):
    """The place of each of the muscles of an order among all, by the time they take; the same as before if alike."""
    place = wp.tid()
    own = took[order[place]]
    before = wp.int32(0)
    for other in range(order.shape[0]):
        time = took[order[other]]
        if time > own or (time == own and other < place):
            before += 1
    rank[before] = order[place]
