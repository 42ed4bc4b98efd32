"""Activation dynamics against OpenSim, closed forms and a queue."""

import numpy as np
import pytest
from probes import evaluate

from warpmuscle.kernels.muscle import activation
from warpmuscle.model.muscles import neural_mix

TIMES = {"Thelen2003": activation.THELEN_TIMES, "Millard2012Equilibrium": activation.MILLARD_TIMES}


@pytest.mark.parametrize("name", TIMES)
def test_rate_of_activation_is_that_of_opensim(name: str, reference_data):
    table = reference_data / "opensim_reference" / f"activation_dynamics_{name}Muscle.csv"
    u, a, expected = np.loadtxt(table, delimiter=",", skiprows=1).T
    rate = evaluate(activation.activation_rate, a, u, *TIMES[name])
    np.testing.assert_allclose(rate * (u - a), expected, rtol=1e-5, atol=1e-5)


def test_small_step_follows_the_rate():
    a, u = np.random.default_rng(0).random((2, 200))
    rate = evaluate(activation.activation_rate, a, u, 0.01, 0.04)
    moved = evaluate(activation.activation_relaxed, a, u, rate, 1e-3)
    np.testing.assert_allclose(moved - a, 1e-3 * rate * (u - a), atol=0.5 * (1e-3 * rate.max()) ** 2)


def test_rate_by_excitation_goes_from_that_of_deactivation_to_that_of_activation():
    # Hyfydy User Manual 1.0.2: a' = (u - a)(c1 u + c2), with c2 = 25/s and c1 + c2 = 100/s.
    u = np.linspace(0.0, 1.0, 11)
    got = evaluate(activation.excited_rate, u, 1.0 / 100.0, 1.0 / 25.0)
    np.testing.assert_allclose(got, 75.0 * u + 25.0, rtol=1e-6)


def test_relaxation_is_exact_at_a_constant_rate_and_stable_in_long_steps():
    steps = np.array([1e-4, 1e-2, 1.0, 100.0])
    got = evaluate(activation.activation_relaxed, 0.9, 0.2, 50.0, steps)
    np.testing.assert_allclose(got, 0.2 + 0.7 * np.exp(-50.0 * steps), atol=1e-6)


def test_euler_step_of_the_report_approaches_the_excitation_geometrically():
    a = np.array([0.0])
    for _ in range(100):
        a = evaluate(activation.activation_step, a, 0.7, 100.0, 0.0005)
    np.testing.assert_allclose(a, 0.7 * (1.0 - 0.95**100), atol=1e-6)


def test_euler_step_stays_between_zero_and_one():
    a, u = np.random.default_rng(0).uniform(-1.0, 2.0, (2, 200))
    got = evaluate(activation.activation_step, a, u, 1000.0, 0.01)
    assert got.min() == 0.0
    assert got.max() == 1.0


@pytest.mark.parametrize("delay", [0, 1, 9, 39])
def test_delay_equals_a_queue_that_starts_full_of_the_first_value(delay: int):
    written = np.arange(200)
    slot = evaluate(activation.delayed_slot, written, delay, 64).astype(int)
    ring, read = np.zeros(64, dtype=int), []
    for step in written:
        ring[step % 64] = step
        read.append(ring[slot[step]])
    assert read == [0] * delay + list(range(200 - delay))


# Neural dynamics.

NEURAL, RISE, FALL, STEP = 0.001, 0.05, 0.08, 0.001  # s


def neural_steps(excitation: np.ndarray, start: float, time: float) -> np.ndarray:
    """Activations and neural signals (n, 2) after steps of one time constant under excitations (n,)."""
    rest, neural_rest = np.exp(-STEP / time), np.exp(-STEP / NEURAL)
    mix = NEURAL / (NEURAL - time) * (neural_rest - rest)
    state, history = np.array([[start, start]]), []
    for u in excitation:
        state = evaluate(activation.neural_step, state[:, 0], state[:, 1], u, rest, neural_rest, mix)
        history.append(state[0])
    return np.array(history)


@pytest.mark.parametrize(("start", "end"), [(0.05, 0.9), (0.9, 0.1)])
def test_neural_dynamics_is_exact_for_constant_excitations(start: float, end: float):
    """Against the closed form of two first-order lags in a row (Cruz Ruiz 2015, eq. 11)."""
    t = STEP * np.arange(1, 101)
    got = neural_steps(np.full(100, end), start, RISE)
    shape = (RISE * np.exp(-t / RISE) - NEURAL * np.exp(-t / NEURAL)) / (RISE - NEURAL)
    np.testing.assert_allclose(got[:, 0], end + (start - end) * shape, atol=2e-6)
    np.testing.assert_allclose(got[:, 1], end + (start - end) * np.exp(-t / NEURAL), atol=1e-6)


def test_neural_dynamics_of_equal_time_constants_has_a_limit():
    nearly, equal = (neural_mix(STEP, 0.01, time) for time in (0.01 * (1.0 + 1e-4), 0.01))
    assert float(equal) == pytest.approx(STEP / 0.01 * np.exp(-STEP / 0.01), rel=1e-5)
    assert float(nearly) == pytest.approx(float(equal), rel=1e-3)


# Rates 1/tau, 1/s, by Thelen 2003, eq. 1 and 2: tau = rise (0.5 + 1.5 a) where u > a, fall / (0.5 + 1.5 a) where u < a.
# Time constants are those of OpenSim's muscles: 15 and 50 ms (Thelen), 10 and 40 ms (Millard).
RATES = [
    ("Thelen2003", 0.0, 1.0, 133.33333), ("Thelen2003", 0.5, 1.0, 53.33333), ("Thelen2003", 0.9, 1.0, 36.03604),
    ("Thelen2003", 0.1, 0.0, 13.0), ("Thelen2003", 0.5, 0.0, 25.0), ("Thelen2003", 1.0, 0.0, 40.0),
    ("Millard2012Equilibrium", 0.0, 1.0, 200.0), ("Millard2012Equilibrium", 0.5, 1.0, 80.0),
    ("Millard2012Equilibrium", 0.5, 0.0, 31.25), ("Millard2012Equilibrium", 1.0, 0.0, 50.0),
]  # fmt: skip


@pytest.mark.parametrize(("name", "activated", "excitation", "expected"), RATES)
def test_rate_of_activation_is_that_of_the_publication(name, activated, excitation, expected):
    rate = evaluate(activation.activation_rate, activated, excitation, *TIMES[name])
    assert rate == pytest.approx(expected, rel=1e-6)
