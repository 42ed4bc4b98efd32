"""Synergies that made the signals are found again, by the library's factorisation; synergies are matched."""

import numpy as np
import pytest
from sklearn.decomposition import NMF
from synthetic_emg import WEIGHTS, coefficients, raw_emg

from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.emg import Chain, band_passed, envelope
from warpmuscle.synergy.factorization import factorize, match, reconstruct

TIME = np.arange(300) / 50.0
EXACT = (WEIGHTS @ coefficients(TIME)).T


def test_known_synergies_are_recovered():
    found = factorize(EXACT, 3)
    order, cosines = match(WEIGHTS, found.weights)
    assert cosines.min() > 0.999
    assert found.account.vaf > 0.9999
    scaled = found.ordered(order)
    np.testing.assert_allclose(scaled.weights, WEIGHTS, atol=0.03)  # the greatest weight of each is 1 here, too
    np.testing.assert_allclose(scaled.coefficients, coefficients(TIME), atol=0.03)


def test_known_synergies_are_recovered_from_raw_emg():
    raw = raw_emg(30.0)
    found = factorize(envelope(band_passed(raw, Chain()), Chain()).values[::10], 3)
    assert match(WEIGHTS, found.weights)[1].min() > 0.99


def test_scale_and_order_follow_the_convention():
    noisy = EXACT + 0.05 * np.random.default_rng(0).random(EXACT.shape)
    found = factorize(noisy, 4)
    np.testing.assert_allclose(found.weights.max(axis=0), 1.0)
    explained = np.sum(found.weights**2, axis=0) * np.sum(found.coefficients**2, axis=1)
    assert np.all(np.diff(explained) <= 0.0)


def test_accounts_are_what_they_say():
    noisy = EXACT + 0.1 * np.random.default_rng(0).random(EXACT.shape)
    found = factorize(noisy, 2)
    error = noisy - (found.weights @ found.coefficients).T
    assert found.account.vaf == pytest.approx(1.0 - np.sum(error**2) / np.sum(noisy**2))
    assert found.account.vaf == pytest.approx(found.account.restart_vaf.max(), abs=1e-9)
    expected = [1.0 - np.sum(error[:, m] ** 2) / np.sum(noisy[:, m] ** 2) for m in range(7)]
    np.testing.assert_allclose(found.account.muscle_vaf, expected)
    assert found.account.r2 == pytest.approx(1.0 - np.sum(error**2) / np.sum((noisy - noisy.mean()) ** 2))


def test_restarts_are_never_worse_than_a_run_of_the_library():
    noisy = np.random.default_rng(1).random((80, 9))
    model = NMF(4, init="random", random_state=0, max_iter=1000)
    rest = noisy - model.fit_transform(noisy) @ model.components_
    assert factorize(noisy, 4).account.vaf >= 1.0 - np.sum(rest**2) / np.sum(noisy**2) - 1e-3


def test_same_seed_gives_the_same_bits_and_restarts_vary():
    noisy = np.random.default_rng(1).random((80, 9))
    first, second = factorize(noisy, 4, seed=3), factorize(noisy, 4, seed=3)
    assert np.array_equal(first.weights, second.weights)
    assert np.array_equal(first.coefficients, second.coefficients)
    assert np.ptp(first.account.restart_vaf) > 0.0
    assert not np.array_equal(first.account.restart_vaf[1:], factorize(noisy, 4, seed=4).account.restart_vaf[1:])


def test_coefficients_of_given_synergies_are_found():
    np.testing.assert_allclose(reconstruct(EXACT, WEIGHTS), coefficients(TIME), atol=1e-9)


def test_match_finds_a_permutation_and_leaves_the_rest_behind():
    order, cosines = match(WEIGHTS, np.column_stack([np.ones(7), 3.0 * WEIGHTS[:, [2, 0, 1]]]))
    assert order == [2, 3, 1, 0]
    np.testing.assert_allclose(cosines, 1.0)
    assert match(WEIGHTS, WEIGHTS[:, [1]])[0] == [0]
    with pytest.raises(SignalError, match="synergies of 7 and of 5 muscles cannot be matched"):
        match(WEIGHTS, WEIGHTS[:5])


def test_more_synergies_than_channels_are_refused():
    with pytest.raises(SignalError, match="8 synergies are more than the 7 channels with 300 samples allow"):
        factorize(EXACT, 8)


@pytest.mark.parametrize("value", [-0.1, np.nan, np.inf])
def test_activations_that_cannot_be_factorised_are_refused(value):
    wrong = EXACT.copy()
    wrong[5, 2] = value
    with pytest.raises(SignalError, match="activations must be finite, not negative"):
        factorize(wrong, 2)
