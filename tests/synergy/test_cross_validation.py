"""Cross-validation finds the number of synergies that activations were made of, whatever one muscle does by itself."""

import numpy as np
import pytest
from synthetic_emg import WEIGHTS, coefficients

from warpmuscle.synergy.cross_validation import cross_validate, fill_gaps, memory
from warpmuscle.synergy.extraction import Rule, extract

TIME = np.arange(500) / 50.0


def noisy(level, seed=0):
    """Activations (T, 7) of three synergies, with noise."""
    rng = np.random.default_rng(seed)
    return (WEIGHTS @ coefficients(TIME)).T * (1.0 + 0.2 * rng.normal(size=(500, 1))) + level * rng.random((500, 7))


@pytest.mark.parametrize("seed", [0, 1])
def test_three_synergies_are_found_in_activations_of_three(seed):
    prediction = cross_validate(noisy(0.05, seed), 6, seed)
    assert prediction.count == 3
    assert prediction.error[2] < 0.5 * prediction.error[1]


def test_a_weak_muscle_by_itself_asks_for_no_synergy():
    activations = noisy(0.05)
    alone = 0.3 * np.exp(-(((TIME % 1.1 - 0.5) / 0.07) ** 2))
    assert cross_validate(np.column_stack([activations, alone]), 6).count == 3


def test_gaps_are_filled_from_the_other_muscles():
    exact = (WEIGHTS @ coefficients(TIME)).T
    gaps = np.zeros(exact.shape, dtype=bool)
    gaps[80:100, 2] = True  # of a muscle that shares its only synergy with two others
    rest = (exact - fill_gaps(exact, gaps, 3, np.random.default_rng(0)))[gaps]
    assert np.sum(rest**2) < 0.1 * np.sum(exact[gaps] ** 2)


def test_signals_remember_as_long_as_their_bumps_are_wide():
    wave = np.sin(2.0 * np.pi * np.arange(600) / 120.0)[:, None] + 1.0
    assert memory(wave) == pytest.approx(20, abs=2)  # where its cosine is one half


def test_a_rule_may_ask_for_cross_validation():
    assert extract(noisy(0.05), Rule.of("cross", 0.95, 0.75), restarts=1)[0].account.count == 3
