"""How arrays lie in the memory of a device."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.core.arrays import instance_zeros
from warpmuscle.kernels.structs import FootCycle

SHAPES = [(5,), (5, 3), (5, 2, 3), (0, 3), (1, 4)]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dtype", [float, int, wp.vec3, wp.float64, FootCycle])
def test_zeros_of_instances_are_zeros_of_their_shape_wherever_they_lie(shape: tuple[int, ...], dtype: object):
    for side_by_side in (False, True):
        array = instance_zeros(shape, dtype, "cpu", side_by_side)
        assert array.shape == shape
        assert not array.numpy().tobytes().strip(b"\0")


def test_numbers_of_neighbouring_instances_lie_side_by_side_or_those_of_one_instance_do():
    own, beside = (instance_zeros((5, 2, 3), wp.vec3, "cpu", side_by_side) for side_by_side in (False, True))
    assert own.strides == (72, 36, 12)
    assert beside.strides == (12, 180, 60)
    values = np.random.default_rng(1).normal(size=(5, 2, 3, 3)).astype(np.float32)
    for array in (own, beside):
        array.assign(values)
        np.testing.assert_array_equal(array.numpy(), values)
    assert own.is_contiguous
    assert not beside.is_contiguous
