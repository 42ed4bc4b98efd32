"""The order in which warps take muscles."""

import numpy as np
import warp as wp

from warpmuscle.kernels.memory.work_order import rank_muscles


def test_muscles_that_took_longest_come_first_and_those_alike_stay_in_order():
    rng = np.random.default_rng(1)
    order = rng.permutation(60).astype(np.int32)
    took = rng.integers(0, 20, 60).astype(np.int32)
    ranked = wp.zeros(60, dtype=int, device="cpu")
    given = [wp.array(values, dtype=int, device="cpu") for values in (took, order)]
    wp.launch(rank_muscles, 60, given, [ranked], device="cpu")
    expected = order[np.argsort(-took[order], kind="stable")]
    assert ranked.numpy().tolist() == expected.tolist()


def test_an_order_stays_as_it_is_as_long_as_no_time_is_known():
    order = np.array([3, 0, 2, 1], dtype=np.int32)
    ranked = wp.zeros(4, dtype=int, device="cpu")
    given = [wp.array(values, dtype=int, device="cpu") for values in (np.zeros(4, np.int32), order)]
    wp.launch(rank_muscles, 4, given, [ranked], device="cpu")
    assert ranked.numpy().tolist() == order.tolist()
