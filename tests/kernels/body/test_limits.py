"""Limited angles, their rates and the torques of limits against rotations in float64 and finite differences."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled, turn_about, units, vectors

from biped import multiply, rotate
from warpmuscle.kernels.body import limits
from warpmuscle.kernels.structs import HINGE, UNIVERSAL, Model, Scratch, Skeleton, State

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


def test_ball_angles_invert_the_composition():
    frame, angles = axes(1), random_angles(3)
    q = ball(angles, *frame)
    for sign in (1.0, -1.0):
        np.testing.assert_allclose(evaluate(limits.ball_angles, sign * q, frame[0], frame[2]), angles, atol=1e-5)


def test_ball_rates_are_the_derivatives_of_the_angles():
    """Composed in float64 and differentiated: the relative angular velocity of given rates gives them back."""
    swing, middle, twist = axes(1)
    angles, rates, step = random_angles(3, middle=1.3), vectors(N, 4), 1e-6
    q = ball(angles, swing, middle, twist)
    change = multiply(ball(angles + step * rates, swing, middle, twist), q * INVERSE)
    velocity = 2.0 * change[:, :3] / step  # in the parent's frame, which is the world here
    rows = evaluate(limits.ball_rate_axes, swing, rotate(q, twist))
    np.testing.assert_allclose(np.einsum("nij,nj->ni", rows, velocity), rates, atol=3e-5)


def test_ball_rates_stay_bounded_in_gimbal_lock():
    swing = units(N)
    rows = evaluate(limits.ball_rate_axes, swing, swing + 1e-9)
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
    got = evaluate(limits.ball_within, q, swing, twist, np.cos(centre), np.sin(centre), half_cosine)
    inside = (angles >= low) & (angles <= high) | (half >= np.pi)
    margin = np.minimum(np.abs(angles - low), np.abs(angles - high)).min(axis=1)
    clear = margin > 1e-3
    assert np.array_equal(got[clear], inside.all(axis=1)[clear])
    assert 10 < np.count_nonzero(inside.all(axis=1)) < N - 10


def test_limit_pushes_back_like_a_spring_with_an_implicit_damper():
    angle, rate = np.array([0.6, -0.7, 0.5001]), np.array([0.3, -0.2, 0.0])
    torque, inertia = evaluate(limits.limit_torque, angle, rate, -0.4, 0.5, 4000.0, 20.0, 0.0005).T
    excess = np.array([0.1, -0.3, 0.0001])
    np.testing.assert_allclose(torque, -4000.0 * excess - (20.0 + 0.0005 * 4000.0) * rate, rtol=1e-3)
    np.testing.assert_allclose(inertia, 0.0005 * (20.0 + 0.0005 * 4000.0), rtol=1e-6)


def test_limit_never_pulls_and_is_nothing_within():
    angle, rate = np.array([0.0, 0.49, -0.4, 0.51, -0.41]), np.array([9.0, -9.0, 0.0, -50.0, 50.0])
    assert np.all(evaluate(limits.limit_torque, angle, rate, -0.4, 0.5, 4000.0, 20.0, 0.0005) == 0.0)


@wp.kernel(enable_backward=False)
def push_back(body: int, model: Model, state: State, work: Scratch):
    its = work
    limits.limit_stage(0, body, model, state, its)


@pytest.mark.parametrize("beyond", [(0.0, 0.0), (0.2, 0.0), (-0.3, 0.0), (0.0, 0.15), (0.1, -0.25)])
@pytest.mark.parametrize("kind", [HINGE, UNIVERSAL])
def test_each_axis_of_a_joint_is_pushed_back_within_its_own_limits(kind: int, beyond: tuple[float, float]):
    """By the spring-damper of its excess at speeds at the moment itself; on the body, the opposite on its parent."""
    low, high, stiffness, damping, step = np.array([-0.5, -1.2, 0.0]), np.array([0.4, 0.9, 0.0]), 400.0, 3.0, 0.001
    beyond_both = np.array(beyond)
    q = np.where(beyond_both > 0, high[:2], np.where(beyond_both < 0, low[:2], [0.1, -0.2])) + beyond_both
    v, a, turned = np.array([0.7, -0.4]), np.array([20.0, -30.0]), np.array([np.eye(3), np.eye(3)[[1, 2, 0]]])
    first, second = np.array([0.6, 0.0, 0.8]), np.array([0.0, 1.0, 0.0])
    plan = {"joint_type": [0, kind], "parent": [-1, 0], "coordinate_start": [0, 0], "speed_start": [0, 0]}
    own = {"low": low, "high": high, "stiffness": stiffness, "damping": damping}
    skeleton = filled(
        Skeleton, plan=plan, row={"axis_a": np.tile(first, (1, 2, 1)), "axis_b": np.tile(second, (1, 2, 1))},
        limits={name: np.broadcast_to(value, (1, 2, *np.shape(value))) for name, value in own.items()},
    )  # fmt: skip
    model = filled(Model, time_step=step, skeleton=skeleton)
    given = {"coordinates": q, "speeds": v, "accelerations": a}
    state = filled(State, **{name: np.float32([values]) for name, values in given.items()})
    stiff = wp.zeros(2, dtype=Scratch.vars["stiffness"].type.dtype, device="cpu")
    work = filled(Scratch, rotation=np.float32(turned), torque=np.zeros((2, 3), np.float32), stiffness=stiff)
    wp.launch(push_back, 1, [1, model, state, work], device="cpu")
    expected = np.zeros(3)
    for k, axis in enumerate((turned[1] @ first, turned[0] @ second)[: 2 if kind == UNIVERSAL else 1]):
        rate = v[k] - 0.5 * step * a[k]
        push = -stiffness * beyond_both[k] - (damping + step * stiffness) * rate
        expected -= axis * push * (push * beyond_both[k] < 0.0)
    np.testing.assert_allclose(work.torque.numpy()[1], expected, rtol=1e-4, atol=1e-4)
    assert np.all(work.torque.numpy()[0] == 0.0)
    assert np.any(stiff.numpy()[1] != 0.0) == bool(np.any(expected))
