"""A learnt policy acts as its network says, with the same bits in batches of any size."""

import numpy as np
import pytest
import warp as wp

from small_policy import small_policy
from warpmuscle.core.errors import RolloutError
from warpmuscle.learning.policy import DevicePolicy, actions_of
from warpmuscle.results.learned import PolicyTable


def exact(policy: PolicyTable, observation):
    """The network by its definition in double precision, one number after the other."""
    found = []
    for row in np.asarray(observation, dtype=np.float64):
        values = [
            min(max((x - m) / d, -policy.widest), policy.widest)
            for x, m, d in zip(row, policy.mean, policy.deviation, strict=True)
        ]
        for number, layer in enumerate(policy.layers):
            values = [
                sum(float(w) * v for w, v in zip(weights, values, strict=True)) + float(bias)
                for weights, bias in zip(layer.weight, layer.bias, strict=True)
            ]
            if number + 1 < len(policy.layers):
                values = [v if v > 0.0 else np.exp(v) - 1.0 for v in values]
        found.append(values)
    return np.array(found)


def on_device(policy, observation):
    observation = np.ascontiguousarray(observation, dtype=np.float32)
    return DevicePolicy(policy, len(observation), "cpu").act(wp.array(observation, dtype=float, device="cpu")).numpy()


def test_numpy_and_the_device_give_what_the_network_is_in_double_precision():
    policy, observation = small_policy(), np.random.default_rng(1).normal(size=(20, 9)) * 4.0
    wanted = exact(policy, observation)
    np.testing.assert_allclose(actions_of(policy, observation), wanted, rtol=2e-5, atol=2e-5)
    np.testing.assert_allclose(on_device(policy, observation), wanted, rtol=2e-5, atol=2e-5)


def test_an_observation_gives_the_same_bits_in_every_slot_of_every_batch():
    policy, observation = small_policy(40, (64, 32), 12), np.random.default_rng(2).normal(size=(67, 40))
    alone = np.concatenate([on_device(policy, row[None]) for row in observation])
    np.testing.assert_array_equal(on_device(policy, observation), alone)
    np.testing.assert_array_equal(on_device(policy, observation[::-1]), alone[::-1])
    np.testing.assert_array_equal(on_device(policy, observation[3:30]), alone[3:30])


def test_observations_of_another_shape_are_refused():
    with pytest.raises(RolloutError, match=r"shape \(3, 8\); the policy takes \(n, 9\)"):
        actions_of(small_policy(), np.zeros((3, 8)))
