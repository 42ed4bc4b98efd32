"""The order in which warps take muscles."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.memory.work_order import rank_muscles


def ranked(took: np.ndarray, order: np.ndarray, size: int) -> list[int]:
    """The order that follows."""
    result = wp.zeros(len(order), dtype=int, device="cpu")
    given = [wp.array(values.astype(np.int32), dtype=int, device="cpu") for values in (took, order)]
    wp.launch(rank_muscles, len(order), [size, *given], [result], device="cpu")
    return [int(muscle) for muscle in result.numpy()]


def test_muscles_that_took_longest_come_first_and_those_alike_stay_in_order():
    rng = np.random.default_rng(1)
    order, took = rng.permutation(60), rng.integers(0, 20, 60)
    assert ranked(took, order, 1) == order[np.argsort(-took[order], kind="stable")].tolist()


@pytest.mark.parametrize("size", [2, 8])
def test_those_that_a_warp_takes_at_a_time_stay_together(size: int):
    rng = np.random.default_rng(2)
    order, took = rng.permutation(61), rng.integers(0, 90, 61)
    full = order[: 61 // size * size].reshape(-1, size)
    slowest = took[full].max(axis=1)
    expected = [*full[np.argsort(-slowest, kind="stable")].ravel(), *order[full.size :]]
    assert ranked(took, order, size) == expected


def test_an_order_stays_as_it_is_as_long_as_no_time_is_known():
    order = np.array([3, 0, 2, 1])
    assert ranked(np.zeros(4), order, 1) == order.tolist()
