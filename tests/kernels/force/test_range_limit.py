"""Laws of devices on joints, against NumPy."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.force.devices import RangeLimit, range_limit_effort


@wp.kernel(enable_backward=False)
def efforts(q: wp.array[float], v: wp.array[float], limit: RangeLimit, result: wp.array[float]):
    i = wp.tid()
    result[i] = range_limit_effort(q[i], v[i], limit)


def limit_of(damping: float) -> RangeLimit:
    limit = RangeLimit()
    limit.low, limit.high, limit.stiffness, limit.damping = -0.5, 1.0, 114.592, damping
    return limit


@pytest.mark.parametrize("damping", [0.0, 2.86479])
def test_a_range_limit_pushes_the_more_the_faster_it_is_bent_and_never_pulls(damping: float):
    q, v = (
        grid.ravel().astype(np.float32) for grid in np.meshgrid(np.linspace(-0.9, 1.4, 24), np.linspace(-3.0, 3.0, 13))
    )
    result = wp.zeros(len(q), device="cpu")
    wp.launch(
        efforts, len(q), [wp.array(q, device="cpu"), wp.array(v, device="cpu"), limit_of(damping), result], device="cpu"
    )
    depth = np.maximum(q - 1.0, 0.0) + np.maximum(-0.5 - q, 0.0)  # as Hunt and Crossley's, of either end
    rate = np.where(q > 1.0, v, -v)
    size = 114.592 * depth * np.maximum(1.0 + damping * rate, 0.0)
    np.testing.assert_allclose(result.numpy(), np.where(q > 1.0, -size, size), atol=2e-4)
    assert np.all(result.numpy()[(q >= -0.5) & (q <= 1.0)] == 0.0)
