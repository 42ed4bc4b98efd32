"""Foot placement against the pendulums that it is made of, in float64."""

import numpy as np
import pytest
from probes import evaluate
from scipy.integrate import solve_ivp

from warpmuscle.kernels.control.walking.inverted_pendulum import (
    LEAST_HASTE,
    MOST_HASTE,
    falling_rate,
    falls_to,
    haste,
    resting_distance,
    steady_margin,
    steady_retreat,
    towards,
)

G = 9.81


@pytest.mark.parametrize("speed", [-1.2, 0.0, 0.4, 1.8])
@pytest.mark.parametrize("height", [0.5, 0.95])
def test_a_pendulum_over_the_foothold_comes_to_rest_upright(speed: float, height: float):
    distance = evaluate(resting_distance, speed, height, G)[0]
    length = np.hypot(height, distance)
    # All kinetic energy becomes height: the pendulum is as long as it is high in the end.
    assert 0.5 * speed**2 + G * height == pytest.approx(G * length, rel=1e-5)
    assert np.sign(distance) == np.sign(speed)


def test_the_linear_pendulum_falls_as_its_equation_says():
    height, place, speed, time = 0.93, -0.14, 0.9, 0.37
    rate = evaluate(falling_rate, height, G)[0]
    solved = solve_ivp(lambda t, y: [y[1], G / height * y[0]], (0.0, time), [place, speed], rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(evaluate(falls_to, place, speed, rate, time)[0], solved.y[:, -1], rtol=1e-5)


def test_retreat_and_margin_make_a_walk_of_the_linear_pendulum_that_repeats_itself():
    height, duration, wanted, width = 0.95, 0.45, 1.3, 0.2
    rate = np.sqrt(G / height)
    retreat = evaluate(steady_retreat, wanted, rate, duration)[0]
    margin = evaluate(steady_margin, width, rate, duration)[0]
    along, across, foot, side = np.array([0.0, wanted]), np.array([0.0, 0.0]), np.zeros(2), 1.0
    feet, speeds = [], []
    for _ in range(60):
        along = falls(along[0] - foot[1], along[1], rate, duration) + np.array([foot[1], 0.0])
        across = falls(across[0] - foot[0], across[1], rate, duration) + np.array([foot[0], 0.0])
        foot = np.array([across[0] + across[1] / rate + side * margin, along[0] + along[1] / rate - retreat])
        side = -side
        feet.append(foot)
        speeds.append(along[1])
    steps = np.diff(np.array(feet[-6:]), axis=0)
    np.testing.assert_allclose(steps[:, 1], wanted * duration, rtol=1e-3)  # as long as the speed asks for
    np.testing.assert_allclose(np.abs(steps[:, 0]), width, rtol=1e-3)  # and as wide as the feet are to be apart


def falls(place: float, speed: float, rate: float, time: float) -> tuple[float, float]:
    return (
        place * np.cosh(rate * time) + speed / rate * np.sinh(rate * time),
        place * rate * np.sinh(rate * time) + speed * np.cosh(rate * time),
    )


def test_what_follows_comes_nearer_by_no_more_than_it_may():
    now, wanted = np.array([0.0, 0.0, 1.0, 1.0]), np.array([1.0, 0.05, 0.0, 1.0])
    np.testing.assert_allclose(evaluate(towards, now, wanted, 0.1), [0.1, 0.05, 0.9, 1.0], atol=1e-7)


def test_a_step_that_goes_on_at_its_haste_ends_where_the_pendulum_needs_the_foot():
    height, place, speed, remaining = 0.95, 0.05, 0.7, 0.3
    rate = np.sqrt(G / height)

    def needs(time: float) -> float:
        there = falls(place, speed, rate, time)
        return there[0] + there[1] / rate  # extrapolated centre of mass

    end = falls(place, speed, rate, remaining)
    for shift in (-0.02, 0.01, 0.03):
        factor = evaluate(haste, shift, end[1] + rate * end[0], remaining)[0]
        # Of first order in the shift: what is left over is of its square.
        assert needs(remaining / factor) - needs(remaining) == pytest.approx(shift, abs=3.0 * shift**2)
        assert (factor < 1.0) == (shift > 0.0)  # what is further ahead needs longer
    assert evaluate(haste, -1.0, 0.1, 0.1)[0] == pytest.approx(float(MOST_HASTE))
    assert evaluate(haste, 5.0, 1.0, 0.1)[0] == pytest.approx(float(LEAST_HASTE))
