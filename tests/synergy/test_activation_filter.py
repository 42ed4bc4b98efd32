"""The discrete activation filter against SciPy's and against fine integration of the continuous model."""

import numpy as np
import pytest
from scipy.signal import cont2discrete

from warpmuscle.core.errors import Error
from warpmuscle.synergy.activation_filter import ActivationFilter


@pytest.mark.parametrize("period", [0.0005, 0.001, 0.005, 0.01, 0.1])
@pytest.mark.parametrize(("tau_act", "tau_ne"), [(0.05, 0.001), (0.01, 0.04), (0.05, 0.05), (0.05, 0.05 + 1e-9)])
def test_coefficients_equal_those_of_cont2discrete(period, tau_act, tau_ne):
    model = ([1.0], [tau_act * tau_ne, tau_act + tau_ne, 1.0])
    numerator, denominator, _ = cont2discrete(model, period, "zoh")
    found = ActivationFilter.of(period, tau_act, tau_ne)
    np.testing.assert_allclose([0.0, found.b1, found.b0], numerator.ravel(), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose([1.0, found.a1, found.a0], denominator, rtol=0.0, atol=1e-12)
    assert found.static_gain == pytest.approx(1.0, abs=1e-10)


def test_response_equals_the_continuous_model_in_small_steps():
    excitation = np.random.default_rng(0).random(40)
    found = ActivationFilter.of(0.01).apply(excitation)
    e = a = 0.0
    activation, small = [0.0], 1e-6
    for u in excitation[:-1]:
        for _ in range(10_000):
            e, a = e + small * (u - e) / 0.001, a + small * (e - a) / 0.05
        activation.append(a)
    np.testing.assert_allclose(found, activation, atol=2e-5)


def test_without_neural_constant_it_is_the_first_order_filter():
    found = ActivationFilter.of(0.01, tau_act=0.05, tau_ne=0.0)
    assert (found.b0, found.a0) == (0.0, 0.0)
    assert found.b1 == pytest.approx(1.0 - np.exp(-0.2), abs=1e-15)


def test_settled_filter_keeps_a_constant_and_filters_rows_alone():
    rows = np.stack([np.full(50, 0.3), np.linspace(0.0, 1.0, 50)])
    filtered = ActivationFilter.of(0.01).apply(rows, settled=True)
    np.testing.assert_allclose(filtered[0], 0.3, atol=1e-14)
    np.testing.assert_allclose(filtered[1], ActivationFilter.of(0.01).apply(rows[1]), atol=1e-14)


def test_printed_b0_has_the_gain_and_the_delay_that_the_module_says():
    exact, period = ActivationFilter.of(0.01), 0.01
    a, b = np.exp(-period / 0.001), np.exp(-period / 0.05)
    printed = ActivationFilter(exact.b1, a * b - (a - b) / (0.05 - 0.001), exact.a1, exact.a0)
    assert printed.static_gain == pytest.approx(93.08, abs=0.01)
    step = np.ones(400)
    wanted, normalised = exact.apply(step), printed.apply(step) / printed.static_gain
    assert np.abs(wanted - normalised).max() == pytest.approx(0.163, abs=0.001)
    for response, delay in ((wanted, 0.0561), (normalised, 0.0651)):
        assert period * np.sum(1.0 - response[1:]) + period == pytest.approx(delay, abs=1e-4)


@pytest.mark.parametrize("numbers", [(0.0, 0.05, 0.001), (0.01, 0.0, 0.0), (0.01, 0.05, -0.001), (0.01, np.nan, 0.0)])
def test_constants_that_make_no_filter_are_refused(numbers):
    with pytest.raises(Error, match="an activation filter needs"):
        ActivationFilter.of(*numbers)
