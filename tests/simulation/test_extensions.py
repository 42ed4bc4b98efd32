"""Words of arrays, whichever way they lie in memory."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.core.arrays import instance_zeros
from warpmuscle.kernels.structs import FootCycle
from warpmuscle.simulation.extensions import words, words_a_row


@pytest.mark.parametrize("side_by_side", [False, True])
@pytest.mark.parametrize("dtype", [float, wp.vec3, wp.float64, FootCycle])
@pytest.mark.parametrize("shape", [(5,), (5, 3), (5, 2, 3), (1, 4)])
def test_words_of_an_instance_are_those_of_its_elements_in_their_order(
    shape: tuple[int, ...], dtype: object, side_by_side: bool
):
    array = instance_zeros(shape, dtype, "cpu", side_by_side)
    width = words_a_row(array)
    values = np.random.default_rng(2).integers(0, 2**30, (shape[0], width), dtype=np.int32)
    inner = array.numpy()
    array.assign(values.view(inner.dtype).reshape(inner.shape))
    seen = words(array)
    np.testing.assert_array_equal(seen.numpy().reshape(shape[0], width), values)
    seen.fill_(7)
    assert (array.numpy().copy().view(np.int32) == 7).all()
