"""A learnt policy acts as its network says, with the same bits in batches of any size."""

import numpy as np
import pytest
import warp as wp
from scipy.integrate import quad
from scipy.stats import norm

from small_policy import small_policy
from warpmuscle.core.errors import RolloutError
from warpmuscle.learning.policy import DevicePolicy, actions_of
from warpmuscle.results.learned import ClippedNoise, PolicyTable


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


def test_actions_with_noise_are_the_mean_of_what_is_left_of_them_where_they_are_clipped():
    noise = ClippedNoise(np.array([0.05, 0.25, 1.0, 4.0], np.float32), -0.25, 2.25)
    plain, observation = small_policy(), np.random.default_rng(4).normal(size=(12, 9)) * 2.0
    policy = small_policy(noise=noise)
    wanted = exact(plain, observation)
    for k, width in enumerate(noise.deviation.astype(float)):
        for row in wanted:
            bell = norm(row[k], width)
            inside = quad(
                lambda x, bell=bell: x * bell.pdf(x), noise.low, noise.high, points=[np.clip(row[k], -0.25, 2.25)]
            )
            row[k] = noise.low * bell.cdf(noise.low) + noise.high * bell.sf(noise.high) + inside[0]
    assert wanted.min() >= -0.25
    assert wanted.max() <= 2.25
    np.testing.assert_allclose(actions_of(policy, observation), wanted, atol=2e-5)
    np.testing.assert_allclose(on_device(policy, observation), wanted, atol=2e-5)
    alone = np.concatenate([on_device(policy, row[None]) for row in observation])
    np.testing.assert_array_equal(on_device(policy, observation), alone)


def test_without_ends_noise_changes_no_action_in_the_mean():
    policy, observation = small_policy(), np.random.default_rng(5).normal(size=(12, 9))
    wide = small_policy(noise=ClippedNoise(np.full(4, 0.3, np.float32), -1e6, 1e6))
    np.testing.assert_allclose(on_device(wide, observation), on_device(policy, observation), atol=1e-6)
    np.testing.assert_allclose(actions_of(wide, observation), actions_of(policy, observation), atol=1e-6)


def test_observations_of_another_shape_are_refused():
    with pytest.raises(RolloutError, match=r"shape \(3, 8\); the policy takes \(n, 9\)"):
        actions_of(small_policy(), np.zeros((3, 8)))
