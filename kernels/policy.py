"""A policy's network, one thread an instance and an output, every sum in the same order in batches of any size."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.func
def elu(x: float) -> float:
    """Exponential linear unit (Clevert, Unterthiner and Hochreiter 2016)."""
    return wp.where(x > 0.0, x, wp.exp(wp.min(x, 0.0)) - 1.0)


@wp.kernel
def normalize(
    # in
    observation: wp.array2d[float], mean: wp.array[float], deviation: wp.array[float], widest: float,
    # out
    normal: wp.array2d[float],
):  # fmt: skip
    """Observations less their means, over their deviations, cut off. Launch with dim = (instances, observations)."""
    i, k = wp.tid()
    normal[i, k] = wp.clamp((observation[i, k] - mean[k]) / deviation[k], -widest, widest)


@wp.kernel
def linear(
    # in
    values: wp.array2d[float], weight: wp.array2d[float], bias: wp.array[float], hidden: bool,
    # out
    outputs: wp.array2d[float],
):  # fmt: skip
    """A layer of weights (inputs, outputs); ELU follows a hidden one. Launch with dim = (instances, outputs)."""
    i, j = wp.tid()
    total = bias[j]
    for k in range(weight.shape[0]):
        total += values[i, k] * weight[k, j]
    if hidden:
        total = elu(total)
    outputs[i, j] = total
