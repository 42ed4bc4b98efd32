"""Modules of several people are sorted by likeness."""

import numpy as np
import pytest
from sklearn.metrics import adjusted_rand_score

from warpmuscle.core.errors import SignalError
from warpmuscle.synergy.clusters import cluster_modules

NAMES = tuple("abcdefgh")
COMMON = np.array(
    [[1, 0.8, 0, 0, 0, 0, 0, 0.2], [0, 0, 1, 0.7, 0.1, 0, 0, 0], [0, 0, 0, 0, 1, 0.9, 0.3, 0],
     [0.3, 0, 0, 0, 0, 0, 1, 1]]
).T  # fmt: skip


def people(count, seed=0):
    """Modules of people, of whom each has three or four of the common ones in an order of its own, and which."""
    rng = np.random.default_rng(seed)
    weights, truth = [], []
    for number in range(count):
        held = rng.permutation(4)[: 4 if number % 3 else 3]
        weights.append(np.maximum(COMMON[:, held] + 0.08 * rng.normal(size=(8, len(held))), 0.0))
        truth.extend(held)
    return weights, truth


def test_modules_that_people_share_are_found_and_their_number():
    weights, truth = people(9)
    found = cluster_modules(weights, [NAMES] * 9)
    assert found.count == 4
    assert adjusted_rand_score(truth, found.label) == 1.0
    assert found.people(0) == 9 or found.people(0) >= found.people(3)
    assert found.cosine.min() > 0.9
    for k in range(4):
        kind = COMMON[:, truth[int(np.flatnonzero(found.label == k)[0])]]
        assert np.abs(found.centre[:, k] - kind).max() < 0.2


def test_muscles_may_stand_in_another_order():
    weights, _ = people(4)
    plain = cluster_modules(weights, [NAMES] * 4, 4)
    turned = cluster_modules([weights[0], *(w[::-1] for w in weights[1:])], [NAMES, *[NAMES[::-1]] * 3], 4)
    assert np.array_equal(plain.label, turned.label)
    assert np.allclose(plain.centre, turned.centre)


def test_what_cannot_be_sorted_is_refused():
    weights, _ = people(2)
    with pytest.raises(SignalError, match="at least two people"):
        cluster_modules(weights[:1], [NAMES])
    with pytest.raises(SignalError, match="person 2 does not have the same muscles as the first: h, x"):
        cluster_modules(weights, [NAMES, (*NAMES[:-1], "x")])
    with pytest.raises(SignalError, match="40 clusters are not to be had of 7 modules"):
        cluster_modules(weights, [NAMES] * 2, 40)


def test_people_who_are_alike_to_the_last_bit_are_one_cluster_a_module():
    found = cluster_modules([COMMON, COMMON], [NAMES] * 2)
    assert found.count == 4
    assert found.cosine.min() == pytest.approx(1.0)
