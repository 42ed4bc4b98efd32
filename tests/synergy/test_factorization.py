"""Synergies that made the signals are found again; numbers of synergies are chosen by rules; synergies are matched."""

import numpy as np
import pytest
from sklearn.decomposition import NMF
from synthetic_emg import WEIGHTS, coefficients, raw_emg

from warpmuscle.errors import SignalError
from warpmuscle.synergy.emg import Chain, band_passed, envelope
from warpmuscle.synergy.extraction import Rule, extract, knee, least_sufficient
from warpmuscle.synergy.factorization import Account, factorize, match, reconstruct

TIME = np.arange(300) / 50.0
EXACT = (WEIGHTS @ coefficients(TIME)).T


def account(count, vaf, worst, r2=0.0):
    return Account(count, vaf, np.array([1.0, worst]), r2, np.array([vaf]))


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


def test_fewest_synergies_must_suffice_for_all_and_for_each():
    accounts = [account(1, 0.5, 0.2), account(2, 0.96, 0.6), account(3, 0.97, 0.9)]
    assert least_sufficient(accounts, Rule(vaf=0.95, muscle_vaf=0.75)).count == 3
    assert least_sufficient(accounts, Rule(vaf=0.95, muscle_vaf=0.5)).count == 2
    with pytest.raises(SignalError, match=r"3 synergies account for 0.970 of all and 0.900 of the worst channel, not "):
        least_sufficient(accounts, Rule(vaf=0.99))


def test_knee_is_where_a_straight_line_begins():
    r2 = [0.2, 0.6, 0.9, 0.92, 0.94, 0.96, 0.98]
    assert knee([account(k + 1, value, 0.0, value) for k, value in enumerate(r2)]).count == 3


def test_number_is_found_by_rule_and_asked_for_one_by_one():
    noisy = EXACT + 0.02 * np.random.default_rng(0).random(EXACT.shape)
    asked = []
    found, accounts = extract(noisy, Rule.of("auto", 0.95, 0.75), restarts=2, progress=asked.append)
    assert found.account.count == 3
    assert [a.count for a in accounts] == asked == list(range(1, len(asked) + 1))
    assert extract(noisy, Rule.of("5", 0.95, 0.75), restarts=2)[0].account.count == 5
    assert extract(noisy, Rule.of("knee", 0.95, 0.75), restarts=2)[0].account.count == 3


@pytest.mark.parametrize(
    ("text", "vaf", "says"),
    [("0", 0.9, "at least 1, or auto or knee, not '0'"), ("many", 0.9, "not 'many'"), ("-3", 0.9, "not '-3'"),
     ("auto", 1.5, "a VAF to reach must be from 0 to 1, not 1.5"), ("auto", np.nan, "must be from 0 to 1")],
)  # fmt: skip
def test_rules_that_cannot_be_met_are_refused(text, vaf, says):
    with pytest.raises(SignalError) as caught:
        Rule.of(text, vaf, 0.5)
    assert says in str(caught.value)


def test_more_synergies_than_channels_are_refused():
    with pytest.raises(SignalError, match="8 synergies are more than the 7 channels with 300 samples allow"):
        extract(EXACT, Rule.of("8", 0.9, 0.5))
    with pytest.raises(SignalError, match="8 synergies are more than the 7 channels"):
        factorize(EXACT, 8)


@pytest.mark.parametrize("value", [-0.1, np.nan, np.inf])
def test_activations_that_cannot_be_factorised_are_refused(value):
    wrong = EXACT.copy()
    wrong[5, 2] = value
    with pytest.raises(SignalError, match="activations must be finite, not negative"):
        factorize(wrong, 2)
