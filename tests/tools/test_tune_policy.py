"""The tool that tunes a policy by a few numbers: what it changes, and which walks it calls better."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from small_policy import small_policy
from warpmuscle.learning.policy import actions_of
from warpmuscle.results.learned import ClippedNoise

TOOLS = Path(__file__).parents[2] / "tools"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

from tune_policy import SPEEDS, Tuner, Walked  # noqa: E402

PEOPLE = {
    "cost of transport": 3.3, "angles from key points": 0.4, "deviation of the ground force": 1.0, "stance": 61.0,
    "step width": 0.075, "bodies inside each other": 0.1,
}  # fmt: skip


@pytest.mark.parametrize("noise", [None, ClippedNoise(np.full(4, 0.3, np.float32), -0.25, 2.25)])
def test_a_changed_policy_does_what_was_tried_and_both_sides_change_alike(noise):
    policy = small_policy(noise=noise)
    tuner = Tuner.__new__(Tuner)
    tuner.policy, tuner.groups = policy, [(0, 2), (1,), (3,)]
    change = np.array([0.3, -0.2, 0.0])
    shift = tuner.shifts(change[None])
    np.testing.assert_allclose(shift, [[0.3, -0.2, 0.3, 0.0]], rtol=1e-6)
    seen = np.random.default_rng(1).normal(size=(20, 9)).astype(np.float32)
    np.testing.assert_allclose(actions_of(tuner.changed(change), seen), actions_of(policy, seen, shift), atol=1e-5)
    assert np.abs(actions_of(policy, seen, shift) - actions_of(policy, seen))[:, :3].max() > 0.01


def walked(lasted=1.0, **others):
    return Walked(tuple(PEOPLE | others for _ in SPEEDS), lasted)


def test_what_is_nearer_to_people_costs_less_and_a_fall_costs_more_than_any_walk():
    assert walked().cost < walked(stance=58.0).cost
    assert walked().cost < walked(**{"cost of transport": 3.6}).cost
    assert walked().cost < walked(**{"angles from key points": 0.8}).cost
    assert walked().cost < walked(**{"step width": 0.2}).cost
    assert walked().cost < walked(**{"step width": 0.01}).cost
    assert walked().cost < walked(**{"bodies inside each other": 2.0}).cost
    assert walked().cost == walked(**{"bodies inside each other": None}).cost  # of no shapes
    fallen = replace(walked(lasted=0.9), measures=(None, PEOPLE, PEOPLE))
    assert fallen.cost > walked(stance=50.0, **{"cost of transport": 5.0}).cost
    assert walked(lasted=0.9).cost < walked(lasted=0.5).cost
