"""Numbers of synergies are chosen by rules."""

import numpy as np
import pytest
from synthetic_emg import WEIGHTS, coefficients

from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.extraction import AUTO, Rule, extract, knee, least_sufficient, reason, sufficient
from warpmuscle.synergy.factorization import Account

EXACT = (WEIGHTS @ coefficients(np.arange(300) / 50.0)).T


def account(count, vaf, worst, r2=0.0):
    return Account(count, vaf, np.array([1.0, worst]), r2, np.array([vaf]))


def test_fewest_synergies_must_suffice_for_all_and_for_each():
    accounts = [account(1, 0.5, 0.2), account(2, 0.96, 0.6), account(3, 0.97, 0.9)]
    assert least_sufficient(accounts, Rule(vaf=0.95, muscle_vaf=0.75)).count == 3
    assert least_sufficient(accounts, Rule(vaf=0.95, muscle_vaf=0.5)).count == 2
    with pytest.raises(SignalError, match=r"3 synergies account for 0.970 of all and 0.900 of the worst channel, not "):
        least_sufficient(accounts, Rule(vaf=0.99))


def test_knee_is_where_a_straight_line_begins():
    r2 = [0.2, 0.6, 0.9, 0.92, 0.94, 0.96, 0.98]
    assert knee([account(k + 1, value, 0.0, value) for k, value in enumerate(r2)]).count == 3


def test_one_weak_muscle_does_not_ask_for_many_more_synergies():
    """All but one muscle are accounted for by three; the weak one would take seven."""
    vaf = [0.6, 0.8, 0.93, 0.94, 0.945, 0.95, 0.96, 0.97]
    worst = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 0.9]
    accounts = [Account(k + 1, v, np.array([1.0] * 10 + [w]), v, np.array([v])) for k, (v, w) in
                enumerate(zip(vaf, worst, strict=True))]  # fmt: skip
    assert least_sufficient(accounts, Rule(method=AUTO)).count == 7
    assert sufficient(accounts, Rule(method=AUTO)).count == 3
    said = reason(accounts, Rule(method=AUTO), 3, [f"muscle {k}" for k in range(11)])
    assert "0.95 of all and 0.75 of each channel take 7 (now 0.930 of all, muscle 10 0.300)" in said


def test_bars_that_are_met_next_to_the_knee_decide():
    vaf = [0.6, 0.8, 0.94, 0.955, 0.96, 0.965, 0.97, 0.975]
    accounts = [Account(k + 1, v, np.full(11, v), v, np.array([v])) for k, v in enumerate(vaf)]
    assert sufficient(accounts, Rule(method=AUTO)).count == 4
    assert reason(accounts, Rule(method=AUTO), 4, ["m"] * 11) == ""


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
    [("0", 0.9, "at least 1, or auto, knee or cross, not '0'"), ("many", 0.9, "not 'many'"), ("-3", 0.9, "not '-3'"),
     ("auto", 1.5, "a VAF to reach must be from 0 to 1, not 1.5"), ("auto", np.nan, "must be from 0 to 1")],
)  # fmt: skip
def test_rules_that_cannot_be_met_are_refused(text, vaf, says):
    with pytest.raises(SignalError) as caught:
        Rule.of(text, vaf, 0.5)
    assert says in str(caught.value)


def test_more_synergies_than_channels_are_refused():
    with pytest.raises(SignalError, match="8 synergies are more than the 7 channels with 300 samples allow"):
        extract(EXACT, Rule.of("8", 0.9, 0.5))


def test_the_knee_is_the_default():
    """One weak channel asks for more than the knee; the default does not follow it."""
    vaf = [0.6, 0.8, 0.94, 0.955, 0.96, 0.965, 0.97, 0.975]
    assert Rule() == Rule.of("knee", 0.95, 0.75)
    accounts = [Account(k + 1, v, np.full(11, v), v, np.array([v])) for k, v in enumerate(vaf)]
    assert knee(accounts).count < sufficient(accounts, Rule(method=AUTO)).count
