"""The tool that corrects how fast a policy goes when it is told to: what it takes a command for."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from small_policy import small_policy
from warpmuscle.core.errors import Error
from warpmuscle.learning.policy import actions_of

TOOLS = Path(__file__).parents[2] / "tools"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

from calibrate_speed import OBSERVED, correction, stretched  # noqa: E402


def test_a_stretched_policy_does_what_it_did_at_the_other_speed_and_all_else_alike():
    policy = small_policy()
    policy = replace(policy, observation=(*policy.observation[:3], OBSERVED, *policy.observation[4:]))
    seen = np.random.default_rng(1).normal(size=(20, 9)).astype(np.float32)
    other = seen.copy()
    other[:, 3] = 1.2 * seen[:, 3] - 0.5
    np.testing.assert_allclose(actions_of(stretched(policy, 1.2, -0.5), seen), actions_of(policy, other), atol=1e-5)
    assert np.abs(actions_of(policy, other) - actions_of(policy, seen)).max() > 0.01
    with pytest.raises(Error, match="observes no speed that is wanted"):
        stretched(small_policy(), 1.2, 0.0)


def test_a_runner_that_goes_by_a_line_goes_as_it_is_told_or_nearer_by_a_share():
    told = np.linspace(2.5, 3.6, 12)
    went = 0.8 * told + 0.5
    for share, left in ((1.0, 0.0), (0.5, 0.5), (0.0, 1.0)):
        factor, offset = correction(told, went, share)
        now = 0.8 * (factor * told + offset) + 0.5
        np.testing.assert_allclose(now - told, left * (went - told), atol=1e-12)
    with pytest.raises(Error, match="not go faster"):
        correction(told, -went, 1.0)
