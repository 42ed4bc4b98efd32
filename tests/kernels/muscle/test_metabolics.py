"""Metabolic power against the published formulas in float64, and on states with closed forms."""

import numpy as np
import pytest
from probes import evaluate

from metabolic_powers import bhargava, margaria, umberger, wang
from warpmuscle.kernels.muscle import metabolics

COUNT = 400
V_MAX, L_OPT = 10.0, 0.1


def states(seed: int = 0) -> dict[str, np.ndarray]:
    """Random states: activation, excitation, length/l_opt, speed m/s, force N, force-length, slow fraction, mass kg."""
    low, high = [0.0, 0.0, 0.3, -1.2, 0.0, 0.0, 0.0, 0.05], [1.0, 1.0, 1.8, 1.2, 5000.0, 1.0, 1.0, 2.0]
    names = ("activation", "excitation", "length", "speed", "force", "iso", "slow", "mass")
    return dict(zip(names, np.random.default_rng(seed).uniform(low, high, (COUNT, 8)).T, strict=True))


@pytest.mark.parametrize("net", [True, False])
@pytest.mark.parametrize(
    ("function", "reference", "further"),
    [
        (metabolics.bhargava_power, bhargava, {}),
        (metabolics.wang_power, wang, {}),
        (metabolics.margaria_power, margaria, {}),
        (metabolics.umberger_power, umberger, {"v_max": V_MAX, "l_opt": L_OPT}),
    ],
)
def test_power_is_that_of_the_published_formulas(function, reference, further, net):
    s = states()
    expected = reference(**s, net=net, **further)
    found = evaluate(function, *s.values(), float(net), *further.values())
    np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-3)
    assert expected.std() > 100.0


@pytest.mark.parametrize(("share", "expected"), [(1.0, -300.0), (0.0, 0.0)])
def test_work_of_a_lengthening_fibre_is_given_back_or_lost(share: float, expected: float):
    assert evaluate(metabolics.fibre_work, 600.0, 0.5, share) == pytest.approx(expected)
    assert evaluate(metabolics.fibre_work, 600.0, -0.5, share) == pytest.approx(300.0)


def test_a_resting_muscle_costs_nothing_but_umbergers_least_heat():
    for function in (metabolics.wang_power, metabolics.bhargava_power):
        assert evaluate(function, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.5, 2.0, 1.0) == 0.0
    assert evaluate(metabolics.umberger_power, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.5, 2.0, 1.0, V_MAX, L_OPT) == 2.0


def test_lifting_takes_four_times_its_work_and_lowering_five_sixths():
    lifted, lowered, held = (
        evaluate(metabolics.margaria_power, 1.0, 1.0, 1.0, v, 600.0, 1.0, 0.5, 2.0, 1.0) for v in (-0.5, 0.5, 0.0)
    )
    assert (lifted, lowered, held) == pytest.approx((1200.0, 250.0, 0.0))


def test_a_slow_muscle_held_fully_active_at_its_optimum_costs_114_watts_a_kilogram():
    for function in (metabolics.wang_power, metabolics.bhargava_power):
        assert evaluate(function, 1.0, 1.0, 1.0, 0.0, 1000.0, 1.0, 1.0, 1.0, 1.0) == pytest.approx(40.0 + 74.0)


def test_shortening_costs_a_quarter_more_than_its_work():
    held, moving = (evaluate(metabolics.wang_power, 1.0, 1.0, 1.0, v, 800.0, 1.0, 0.5, 1.0, 0.0) for v in (0.0, -0.5))
    assert moving - held == pytest.approx(1.25 * 800.0 * 0.5, rel=1e-4)


def test_strict_power_counts_a_watt_a_kilogram_of_heat_at_least_and_is_never_negative():
    """OpenSim's probe: enforce_minimum_heat_rate_per_muscle and forbid_negative_total_power."""
    rest = evaluate(metabolics.bhargava_strict_power, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.5, 2.0, 1.0)
    assert rest == pytest.approx(2.0)
    pulled = evaluate(metabolics.bhargava_strict_power, 0.0, 0.0, 1.0, 0.5, 600.0, 1.0, 0.5, 2.0, 1.0)
    assert pulled == 0.0  # takes up 300 W of work, more than the 2 W of heat
    held = evaluate(metabolics.bhargava_strict_power, 1.0, 1.0, 1.0, 0.0, 1000.0, 1.0, 1.0, 1.0, 1.0)
    assert held == pytest.approx(40.0 + 74.0)
    lifting = evaluate(metabolics.bhargava_strict_power, 1.0, 1.0, 1.0, -0.5, 800.0, 1.0, 1.0, 1.0, 1.0)
    assert lifting == pytest.approx(40.0 + 74.0 + 1.25 * 800.0 * 0.5, rel=1e-5)


def test_strict_power_is_never_less_than_net_power():
    s = states(3)
    net = bhargava(**s, net=True)
    found = evaluate(metabolics.bhargava_strict_power, *s.values(), 1.0)
    assert np.all(found >= net - 1e-2)
    enough = (net > 0.0) & (bhargava(**s | {"force": np.zeros(COUNT)}, net=True) > s["mass"])
    np.testing.assert_allclose(found[enough], net[enough], rtol=1e-4, atol=1e-2)
