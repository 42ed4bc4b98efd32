"""What terms weigh by default, against typed numbers: those with which the shipped policies were learnt."""

import pytest

from warpmuscle.kernels.objective.objective_terms import PER_DECISION, REWARDS, TERMS, Term, scoped, signed

WEIGHTS = {
    "speed": 10.0, "progress": 0.0, "alive": 5.0, "upright": 0.0, "pose": 10.0, "imitation": 20.0, "force": 0.0,
    "contact": 0.0, "effort": 3.0, "action": 1.0, "action_rate": 0.0, "overload": 0.0, "heading": 3.0, "side": 3.0,
    "objective": 0.0, "failure": 0.0,
}  # fmt: skip


def test_rewards_weigh_by_default_what_they_did_when_policies_learnt():
    assert {name: term.weight for name, term in REWARDS.items()} == WEIGHTS
    assert set(PER_DECISION) <= set(REWARDS)


def test_no_term_of_an_objective_weighs_anything_by_default():
    assert {term.weight for term in TERMS.values()} == {0.0}


def test_a_shipped_reward_without_a_sign_and_a_term_without_a_scope_are_told():
    assert all(term.sign for term in REWARDS.values())
    with pytest.raises(TypeError, match=r"reward 'calm' in objective_terms.py has no sign"):
        signed(Term("calm", "1/s", "how calm it is"))
    with pytest.raises(TypeError, match=r"term 'calm' in objective_terms.py has no scope"):
        scoped(Term("calm", "how calm it is", "instance"))
