"""Angular velocity and acceleration of a quaternion that is not of unit length, by differences of its orientation."""

import numpy as np
import pytest
import warp as wp
from probes import vectors

from warpmuscle.core.pose import conjugate, multiply, normalized
from warpmuscle.kernels.body.motion import angular_acceleration, quaternion_rate


@wp.kernel(enable_backward=False)
def rates(
    p: wp.array[wp.quat], rate: wp.array[wp.quat], bend: wp.array[wp.quat], world: bool, found: wp.array2d[wp.vec3]
):
    i = wp.tid()
    a = quaternion_rate(p[i], rate[i], world)
    found[i, 0] = 2.0 * wp.vec3(a[0], a[1], a[2])
    found[i, 1] = angular_acceleration(p[i], rate[i], bend[i], world)


@pytest.mark.parametrize("world", [False, True])
def test_a_quaternion_of_any_length_turns_as_its_orientation_does(world: bool):
    """2 vec(q' q^-1) along world axes, 2 vec(q^-1 q') along those of the body, of q = p / |p|; and their rates."""
    p, rate, bend = (np.concatenate([vectors(20, k), vectors(20, k + 9)[:, :1]], axis=1) for k in (1, 2, 3))
    step = 1e-4

    def turned(t: float) -> np.ndarray:
        return normalized(p + t * rate + 0.5 * t * t * bend)

    def spin(t: float) -> np.ndarray:
        change, now = (turned(t + step) - turned(t - step)) / (2.0 * step), conjugate(turned(t))
        return 2.0 * (multiply(change, now) if world else multiply(now, change))[:, :3]

    found = wp.zeros((20, 2), dtype=wp.vec3, device="cpu")
    given = [wp.array(np.float32(v), dtype=wp.quat, device="cpu") for v in (p, rate, bend)]
    wp.launch(rates, 20, [*given, world, found], device="cpu")
    gained = (spin(step) - spin(-step)) / (2.0 * step)
    np.testing.assert_allclose(found.numpy()[:, 0], spin(0.0), rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(found.numpy()[:, 1], gained, rtol=2e-3, atol=1e-4 * np.abs(gained).max())
