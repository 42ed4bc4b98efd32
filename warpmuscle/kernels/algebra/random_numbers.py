"""Random numbers that depend on a seed, the instance, a counter and their purpose alone.

So they are the same in batches of any size, and whatever else was drawn before.
"""

import warp as wp

from warpmuscle.kernels.functions import func

# What they are for.
START, VARIANT, COMMAND, NOISE, PUSH, VELOCITY, GOAL, BOX = range(1, 9)
CUSTOM_START, EXCITATION, DELAY, NOISINESS, PUSHED, AIM = range(9, 15)


@func
def random_of(seed: int, instance: int, counter: int, purpose: int) -> wp.uint32:
    """State of a generator of Warp, for `wp.randf` and its like."""
    of_instance = wp.rand_init(seed, instance)
    of_counter = wp.rand_init(wp.int32(of_instance), counter)
    return wp.rand_init(wp.int32(of_counter), purpose)
