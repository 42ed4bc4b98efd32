"""Steps of static optimisation: the slope of the balance that the first of them takes."""

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.kernels.inverse.static_optimization_steps import LINEAR, Cost, Frames, Group, Groups, balance_of

MUSCLES, SPEEDS = 3, 2
ARMS = np.array([[0.04, -0.02], [0.03, 0.05], [-0.01, 0.02]])  # m, of each muscle about each coordinate
FORCE, RESERVE = np.array([[500.0, 800.0, 300.0], [450.0, 900.0, 350.0]]), np.array([2.0, 3.0])  # N; N m
GAINS = np.array([[0.001, 0.002, 0.003], [0.004, 0.005, 0.006]])
balance = balance_of(LINEAR, False, wp.float64)


@wp.kernel(enable_backward=False)
def balanced(
    groups: Groups, frames: Frames, cost: Cost, bound: wp.array[wp.float64], x: wp.array[wp.float64],
    activation: wp.array2d[float], y: wp.array[wp.float64], h: wp.array[wp.float64], hessian: wp.array3d[wp.float64],
):  # fmt: skip
    for frame in range(2):
        g = Group()
        g.frame = frame
        g.coordinates = SPEEDS
        g.muscles = MUSCLES
        balance(0, g, groups, frames, cost, bound, bound, x, activation, y, h, hessian[frame])


@pytest.mark.parametrize("gains", [GAINS, GAINS[:1]], ids=["of each frame", "of all"])
def test_the_first_step_has_the_slope_of_muscles_that_no_bound_holds(gains: np.ndarray):
    """H = D^2 + B a' B^T, a' the gain of each muscle, though every activation is held at a bound."""
    levers = np.arange(2 * MUSCLES)
    groups = filled(
        Groups, first_coordinate=[0, SPEEDS], coordinate=[0, 1], first_muscle=[0, MUSCLES], muscle=[0, 1, 2],
        first_lever=[0, 2, 4, 6], lever=levers, place=levers % 2,
    )  # fmt: skip
    arms = np.stack([ARMS.ravel(), 1.1 * ARMS.ravel()])
    frames = filled(Frames, moment_arm=arms, active=FORCE, needed=np.ones((2, SPEEDS)), reserve=RESERVE)
    none, held = np.zeros(MUSCLES), np.full_like(gains, -50.0)  # a shift that puts every muscle at its lower bound
    cost = filled(Cost, gain=gains, shift=held, exponent=1.0, low=none, high=none + 1.0)
    zeros = [wp.zeros(count, dtype=wp.float64, device="cpu") for count in (MUSCLES, SPEEDS, MUSCLES, SPEEDS)]
    activation = wp.zeros((2, MUSCLES), dtype=float, device="cpu")
    hessian = wp.zeros((2, SPEEDS, SPEEDS), dtype=wp.float64, device="cpu")
    wp.launch(
        balanced, 1, [groups, frames, cost, zeros[0], zeros[1], activation, zeros[2], zeros[3], hessian], device="cpu"
    )
    assert not activation.numpy().any()
    for frame, found in enumerate(hessian.numpy()):
        b = arms[frame].reshape(MUSCLES, SPEEDS) * FORCE[frame, :, None]
        expected = np.diag(RESERVE**2) + b.T @ (gains[min(frame, len(gains) - 1), :, None] * b)
        np.testing.assert_allclose(np.tril(found), np.tril(expected), rtol=1e-5)
