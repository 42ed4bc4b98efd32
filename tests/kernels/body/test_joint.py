"""Joint rotations and their velocity products against rotations in float64 and finite differences."""

import numpy as np
from probes import evaluate, turn_about, units, vectors

from biped import multiply, rotate
from warpmuscle.kernels.body import joint

N = 200


def random_angles(seed: int, middle: float = 1.4) -> np.ndarray:
    return np.random.default_rng(seed).uniform([-3.1, -middle, -3.1], [3.1, middle, 3.1], (N, 3))


def test_hinge_turns_about_its_axis():
    axis, angle = units(N), np.random.default_rng(1).uniform(-6.0, 6.0, N)
    np.testing.assert_allclose(evaluate(joint.hinge_rotation, axis, angle), turn_about(axis, angle), atol=3e-7)


def test_universal_bias_is_the_change_of_angular_velocity_at_constant_rates():
    """Axis b in a parent that turns at constant speed, axis a in the child: differentiate the angular velocity."""
    parent, a, b, angle, rate = vectors(N, 1), units(N, 2), units(N, 3), random_angles(4), vectors(N, 5, 3.0)
    speed = np.linalg.norm(parent, axis=1)

    def axes_in_world(time: float) -> tuple[np.ndarray, np.ndarray]:
        q = turn_about(parent / speed[:, None], speed * time)
        turned_b = multiply(q, turn_about(b, angle[:, 1] + rate[:, 1] * time))
        return rotate(turned_b, a) * rate[:, :1], rotate(q, b) * rate[:, 1:2]

    step = 1e-5
    change = sum(axes_in_world(step)) - sum(axes_in_world(-step))
    bias = evaluate(joint.universal_bias, parent, *axes_in_world(0.0))
    np.testing.assert_allclose(bias, change / (2.0 * step), atol=2e-5)
