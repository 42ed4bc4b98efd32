"""A policy's network, one thread an instance and an output, every sum in the same order in batches of any size."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.func
def elu(x: float) -> float:
    """Exponential linear unit (Clevert, Unterthiner and Hochreiter 2016)."""
    return wp.where(x > 0.0, x, wp.exp(wp.min(x, 0.0)) - 1.0)


@wp.func
def mean_above(z: float) -> float:
    """Mean of max(z + x, 0) over x of the standard normal distribution: z Phi(z) + phi(z)."""
    root_half = wp.static(0.5**0.5)
    density = wp.static((2.0 * wp.PI) ** -0.5) * wp.exp(-0.5 * z * z)
    return 0.5 * z * wp.erfc(-root_half * z) + density


@wp.func
def clipped_mean(mean: float, noise: float, low: float, high: float) -> float:
    """Mean of clip(x, low, high) over x of a normal distribution, whose standard deviation is the noise."""
    return mean + noise * (mean_above((low - mean) / noise) - mean_above((mean - high) / noise))


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


@wp.kernel
def clip_noise(
    # in
    noise: wp.array[float], low: float, high: float,
    # in and out
    action: wp.array2d[float],
):  # fmt: skip
    """What actions with noise come to in the mean, where they are clipped. Launch with dim = (instances, actions)."""
    i, k = wp.tid()
    action[i, k] = clipped_mean(action[i, k], noise[k], low, high)
