"""Sequences made to rise: the nearest one that never falls."""

import numpy as np

from warpmuscle.core.monotone import rising


def test_neighbours_that_fall_are_pooled_until_none_does():
    np.testing.assert_array_equal(rising([1.0, 3.0, 2.0, 4.0]), [1.0, 2.5, 2.5, 4.0])
    np.testing.assert_array_equal(rising([3.0, 2.0, 1.0]), [2.0, 2.0, 2.0])
    np.testing.assert_array_equal(rising([0.0, 0.0, 5.0]), [0.0, 0.0, 5.0])


def test_no_other_rising_sequence_is_nearer():
    generator = np.random.default_rng(1)
    values = generator.normal(size=12)
    nearest = np.sum((rising(values) - values) ** 2)
    for _ in range(200):
        other = np.sort(rising(values) + 0.1 * generator.normal(size=12))
        assert np.sum((other - values) ** 2) >= nearest - 1e-12
