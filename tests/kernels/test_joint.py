"""Joint angles, rates and limits against rotations in float64 and finite differences."""

import numpy as np
from probes import evaluate, turn_about, units, vectors
from warpmuscle.kernels import joint

from biped import multiply, rotate

N = 200
INVERSE = np.array([-1.0, -1.0, -1.0, 1.0])


def axes(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Right-handed orthonormal axes swing, middle = swing x twist, twist, (N, 3) each."""
    swing = units(N, seed)
    twist = np.cross(swing, units(N, seed + 1))
    twist /= np.linalg.norm(twist, axis=1, keepdims=True)
    return swing, np.cross(swing, twist), twist


def ball(angles: np.ndarray, swing: np.ndarray, middle: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """rot(x, swing) rot(y, middle) rot(z, twist)."""
    x, y, z = angles.T
    return multiply(turn_about(swing, x), multiply(turn_about(middle, y), turn_about(twist, z)))


def random_angles(seed: int, middle: float = 1.4) -> np.ndarray:
    return np.random.default_rng(seed).uniform([-3.1, -middle, -3.1], [3.1, middle, 3.1], (N, 3))


def test_hinge_turns_about_its_axis():
    axis, angle = units(N), np.random.default_rng(1).uniform(-6.0, 6.0, N)
    np.testing.assert_allclose(evaluate(joint.hinge_rotation, axis, angle), turn_about(axis, angle), atol=3e-7)


def test_universal_joint_turns_by_b_of_the_parent_then_by_a_of_the_child():
    a, b, angle = units(N, 1), units(N, 2), random_angles(3)
    expected = multiply(turn_about(b, angle[:, 1]), turn_about(a, angle[:, 0]))
    np.testing.assert_allclose(evaluate(joint.universal_rotation, a, b, *angle[:, :2].T), expected, atol=3e-7)


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


def test_ball_angles_invert_the_composition():
    frame, angles = axes(1), random_angles(3)
    q = ball(angles, *frame)
    for sign in (1.0, -1.0):
        np.testing.assert_allclose(evaluate(joint.ball_angles, sign * q, frame[0], frame[2]), angles, atol=1e-5)


def test_ball_rates_are_the_derivatives_of_the_angles():
    """Composed in float64 and differentiated: the relative angular velocity of given rates gives them back."""
    swing, middle, twist = axes(1)
    angles, rates, step = random_angles(3, middle=1.3), vectors(N, 4), 1e-6
    q = ball(angles, swing, middle, twist)
    change = multiply(ball(angles + step * rates, swing, middle, twist), q * INVERSE)
    velocity = 2.0 * change[:, :3] / step  # in the parent's frame, which is the world here
    rows = evaluate(joint.ball_rate_axes, swing, rotate(q, twist))
    np.testing.assert_allclose(np.einsum("nij,nj->ni", rows, velocity), rates, atol=3e-5)


def test_ball_rates_stay_bounded_in_gimbal_lock():
    swing = units(N)
    rows = evaluate(joint.ball_rate_axes, swing, swing + 1e-9)
    assert np.isfinite(rows).all()
    assert np.abs(rows).max() < 6.0


def test_ball_is_within_its_limits_when_all_its_angles_are():
    swing, middle, twist = axes(1)
    rng, angles = np.random.default_rng(5), random_angles(3)
    low = rng.uniform([-3.1, -1.5, -3.1], [0.0, 0.0, 0.0], (N, 3))
    high = rng.uniform([0.0, 0.0, 0.0], [3.1, 1.5, 3.1], (N, 3))
    high[::4, 2] = low[::4, 2] + 7.0  # more than a full turn: no limit
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    half_cosine = np.where(half < np.pi, np.cos(half), -2.0)
    q = ball(angles, swing, middle, twist)
    got = evaluate(joint.ball_within, q, swing, twist, np.cos(centre), np.sin(centre), half_cosine)
    inside = (angles >= low) & (angles <= high) | (half >= np.pi)
    margin = np.minimum(np.abs(angles - low), np.abs(angles - high)).min(axis=1)
    clear = margin > 1e-3
    assert np.array_equal(got[clear], inside.all(axis=1)[clear])
    assert 10 < np.count_nonzero(inside.all(axis=1)) < N - 10


def test_limit_pushes_back_like_a_spring_with_an_implicit_damper():
    angle, rate = np.array([0.6, -0.7, 0.5001]), np.array([0.3, -0.2, 0.0])
    torque, inertia = evaluate(joint.limit_torque, angle, rate, -0.4, 0.5, 4000.0, 20.0, 0.0005).T
    excess = np.array([0.1, -0.3, 0.0001])
    np.testing.assert_allclose(torque, -4000.0 * excess - (20.0 + 0.0005 * 4000.0) * rate, rtol=1e-3)
    np.testing.assert_allclose(inertia, 0.0005 * (20.0 + 0.0005 * 4000.0), rtol=1e-6)


def test_limit_never_pulls_and_is_nothing_within():
    angle, rate = np.array([0.0, 0.49, -0.4, 0.51, -0.41]), np.array([9.0, -9.0, 0.0, -50.0, 50.0])
    assert np.all(evaluate(joint.limit_torque, angle, rate, -0.4, 0.5, 4000.0, 20.0, 0.0005) == 0.0)
